#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "pictures/chart_colors.h"
#include "pictures/color_scale.h"
#include "pictures/dot_chart.h"
#include "pictures/line_panels.h"
#include "pictures/share_tables.h"

namespace surfit {
namespace {

struct Spot {
  double count = 0, u = 0, v = 0;  // how many pixels of a colour, and their mean
};

Spot SpotOf(Rgb8 color, const Image<Rgb8>& image, int u_end) {
  Spot spot;
  for (int v = 0; v < image.height(); ++v) {
    for (int u = 0; u < u_end; ++u) {
      if (!(image(u, v) == color)) continue;
      ++spot.count;
      spot.u += u;
      spot.v += v;
    }
  }
  spot.u /= spot.count;
  spot.v /= spot.count;
  return spot;
}

TEST(DotChart, PutsLargerValuesFartherToTheRightAndRowsBelowEachOther) {
  DotChart chart;
  chart.series = {"a", "b", "c"};
  chart.groups = {{"group", {{"one", {1, 10, std::nullopt}}, {"two", {std::nullopt, {}, 100}}}}};
  const Image<Rgb8> image = DrawDotChart(chart);
  constexpr int kFigures = 1150;  // of the same colours, to the right of the dots
  const Spot a = SpotOf(SeriesColor(0), image, kFigures),
             b = SpotOf(SeriesColor(1), image, kFigures),
             c = SpotOf(SeriesColor(2), image, kFigures);
  EXPECT_GT(a.count, 50);
  EXPECT_LT(a.u, b.u);
  EXPECT_NEAR(c.u - b.u, b.u - a.u, 3);  // a logarithmic axis; dots at its ends are not cut
  EXPECT_NEAR(a.v, b.v, 2);
  EXPECT_GT(c.v, b.v + 10);
}

TEST(ShareTables, FillCellsWithTheColourOfTheirShare) {
  ShareTables tables;
  tables.row_titles = {"row"};
  tables.column_titles = {"left", "right"};
  tables.cell_row_labels = {"1"};
  tables.cell_column_labels = {"1", "2"};
  tables.tables = {{{{1., std::nullopt}}, {}}};
  const Image<Rgb8> image = DrawShareTables(tables);
  const ColorScale scale(0, 1, false);
  const Spot full = SpotOf(scale.ColorOf(1), image, image.width());
  EXPECT_GT(full.count, 500);  // most of one cell of 44 x 22
  EXPECT_LT(full.count, 44 * 22);
  EXPECT_EQ(SpotOf(scale.ColorOf(0), image, image.width()).count, 0);
}

TEST(LinePanels, DrawEachSeriesInItsColourAndLeaveOutWhatHasNoLogarithm) {
  const std::vector<LinePanel> panels = {{"first", {{"a", {1, 0.1, 0.01}}, {"b", {1, 0.5, 0.2}}}},
                                         {"second", {{"b", {0, -1}}}}};
  const Image<Rgb8> image = DrawLinePanels(panels, "x", "y");
  const int middle = image.width() / 2;
  EXPECT_GT(SpotOf(SeriesColor(0), image, middle).count, 1000);
  EXPECT_GT(SpotOf(SeriesColor(1), image, middle).count, 100);  // thin
  // b falls less: it lies above.
  EXPECT_LT(SpotOf(SeriesColor(1), image, middle).v, SpotOf(SeriesColor(0), image, middle).v);
}

}  // namespace
}  // namespace surfit
