#include "pictures/line_panels.h"

#include <algorithm>
#include <cmath>

#include "pictures/chart_colors.h"
#include "pictures/plot_canvas.h"

namespace surfit {
namespace {

constexpr int kColumns = 4;
constexpr int kPanelWidth = 460, kPanelHeight = 420, kLegendRow = 26;
constexpr int kLegendColumns = 3, kTop = 20;
constexpr double kWidest = 14, kNarrowest = 1.5;

std::vector<std::string> NamesOf(const std::vector<LinePanel>& panels) {
  std::vector<std::string> names;
  for (const LinePanel& panel : panels) {
    for (const LineSeries& series : panel.series) {
      if (std::find(names.begin(), names.end(), series.name) == names.end()) {
        names.push_back(series.name);
      }
    }
  }
  return names;
}

struct Line {
  std::vector<double> x, y;  // y a common logarithm
};

Line LineOf(const LineSeries& series) {
  Line line;
  for (std::size_t i = 0; i < series.values.size(); ++i) {
    if (!(series.values[i] > 0)) continue;
    line.x.push_back(static_cast<double>(i));
    line.y.push_back(std::log10(series.values[i]));
  }
  return line;
}

// All values of a panel, within whole powers of ten.
AxisRanges RangesOf(const LinePanel& panel) {
  AxisRanges ranges{{0, 1}, {1e300, -1e300}};
  for (const LineSeries& series : panel.series) {
    const Line line = LineOf(series);
    for (std::size_t i = 0; i < line.x.size(); ++i) {
      ranges.x.end = std::max(ranges.x.end, line.x[i]);
      ranges.y.begin = std::min(ranges.y.begin, line.y[i]);
      ranges.y.end = std::max(ranges.y.end, line.y[i]);
    }
  }
  if (ranges.y.begin > ranges.y.end) ranges.y = {0, 1};
  constexpr double kMargin = 0.05;
  ranges.y = {std::floor(ranges.y.begin - kMargin), std::ceil(ranges.y.end + kMargin)};
  return ranges;
}

class PanelSheet {
 public:
  PanelSheet(const std::vector<LinePanel>& panels, Image<Rgb8>* image)
      : names_(NamesOf(panels)), canvas_(image) {}

  void Draw(const LinePanel& panel, const PixelBox& box, const std::string& x_label,
            const std::string& y_label) {
    canvas_.SetTextHeight(15);
    canvas_.BeginAxes({box, RangesOf(panel), panel.title, x_label, y_label, true});
    for (const LineSeries& series : panel.series) {
      SetStyle(series.name);
      const Line line = LineOf(series);
      if (line.x.size() > 1) canvas_.Line(line.x, line.y);
    }
    canvas_.UsePixels();
  }

  void DrawLegend(double left, double top, double column_width) {
    for (std::size_t i = 0; i < names_.size(); ++i) {
      const double x = left + column_width * static_cast<double>(i % kLegendColumns);
      const std::size_t row = i / kLegendColumns;
      const double y = top + kLegendRow * (static_cast<double>(row) + 0.5);
      SetStyle(names_[i]);
      canvas_.Line({x, x + 50}, {y, y});
      canvas_.SetColor(kChartInk);
      canvas_.Text(x + 62, y, names_[i]);
    }
  }

 private:
  void SetStyle(const std::string& name) {
    const auto i = std::find(names_.begin(), names_.end(), name) - names_.begin();
    const double share = names_.size() > 1 ? static_cast<double>(i) / (names_.size() - 1.) : 1;
    canvas_.SetColor(SeriesColor(i));
    canvas_.SetLineWidth(kWidest + share * (kNarrowest - kWidest));
  }

  std::vector<std::string> names_;
  PlotCanvas canvas_;
};

}  // namespace

Image<Rgb8> DrawLinePanels(const std::vector<LinePanel>& panels, const std::string& x_label,
                           const std::string& y_label) {
  const int count = static_cast<int>(panels.size());
  const int columns = std::clamp(count, 2, kColumns), rows = (count + kColumns - 1) / kColumns;
  const int legend_rows =
      (static_cast<int>(NamesOf(panels).size()) + kLegendColumns - 1) / kLegendColumns;
  const int width = columns * kPanelWidth;
  Image<Rgb8> image(width, kTop + rows * kPanelHeight + legend_rows * kLegendRow + kTop,
                    kChartPaper);
  {
    PanelSheet sheet(panels, &image);
    for (int i = 0; i < count; ++i) {
      const int left = i % kColumns * kPanelWidth, top = kTop + i / kColumns * kPanelHeight;
      sheet.Draw(panels[i],
                 {left + 90., top + 40., left + kPanelWidth - 15., top + kPanelHeight - 70.},
                 x_label, y_label);
    }
    sheet.DrawLegend(90, kTop + rows * kPanelHeight, (width - 100.) / kLegendColumns);
  }
  return image;
}

}  // namespace surfit
