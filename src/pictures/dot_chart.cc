#include "pictures/dot_chart.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "pictures/chart_colors.h"
#include "pictures/plot_canvas.h"

namespace surfit {
namespace {

constexpr Rgb8 kGrid = {220, 220, 220};
constexpr int kRowHeight = 22, kGroupSpace = 12;
constexpr int kTop = 110, kBottom = 70, kLabelWidth = 380, kPlotWidth = 760, kFigureWidth = 110;

int RowCount(const DotChart& chart) {
  int count = 0;
  for (const DotChart::Group& group : chart.groups) {
    count += 1 + static_cast<int>(group.rows.size());
  }
  return count;
}

// Whole powers of ten around all values.
AxisRange RangeOf(const DotChart& chart) {
  double low = 1e300, high = -1e300;
  for (const DotChart::Group& group : chart.groups) {
    for (const DotChart::Row& row : group.rows) {
      for (const std::optional<double>& value : row.values) {
        if (!value || !(*value > 0)) continue;
        low = std::min(low, std::log10(*value));
        high = std::max(high, std::log10(*value));
      }
    }
  }
  if (low > high) return {0, 1};
  return {std::floor(low), std::max(std::ceil(high), std::floor(low) + 1)};
}

std::string Figure(const std::optional<double>& value) {
  if (!value) return "-";
  char text[50];
  std::snprintf(text, sizeof(text), *value < 100 ? "%.3g" : "%.0f", *value);
  return text;
}

class ChartDrawing {
 public:
  ChartDrawing(const DotChart& chart, Image<Rgb8>* image)
      : chart_(chart), range_(RangeOf(chart)), canvas_(image) {}

  void Draw() {
    const double height =
        kRowHeight * RowCount(chart_) + kGroupSpace * static_cast<double>(chart_.groups.size());
    DrawAxis({kLabelWidth, kTop, kLabelWidth + kPlotWidth, kTop + height});
    DrawHead();
    double y = kTop + 0.5 * kGroupSpace;
    for (const DotChart::Group& group : chart_.groups) {
      canvas_.SetColor(kChartInk);
      canvas_.SetTextHeight(15);
      canvas_.Text(20, y + 0.5 * kRowHeight, group.heading);
      y += kRowHeight;
      for (const DotChart::Row& row : group.rows) {
        DrawRow(row, y + 0.5 * kRowHeight);
        y += kRowHeight;
      }
      y += kGroupSpace;
    }
  }

 private:
  double FigureRight(std::size_t i) const {
    return kLabelWidth + kPlotWidth + kFigureWidth * (static_cast<double>(i) + 1);
  }

  void DrawAxis(const PixelBox& box) {
    canvas_.SetTextHeight(15);
    canvas_.SetLineWidth(1);
    canvas_.SetColor(kGrid);
    for (int power = static_cast<int>(range_.begin) + 1; power < range_.end; ++power) {
      const double x = XOf(power);
      canvas_.Line({x, x}, {box.top, box.bottom});
    }
    canvas_.DrawScale(box, range_, true);
    canvas_.SetColor(kChartInk);
    canvas_.Text(0.5 * (box.left + box.right), box.bottom + 45, chart_.x_label, 0.5);
  }

  double XOf(double logarithm) const {
    return kLabelWidth + kPlotWidth * (logarithm - range_.begin) / (range_.end - range_.begin);
  }

  // The title, and each series' name above its figures in the colour of its dots.
  void DrawHead() {
    canvas_.SetColor(kChartInk);
    canvas_.SetTextHeight(18);
    canvas_.Text(20, 30, chart_.title);
    canvas_.SetTextHeight(15);
    for (std::size_t i = 0; i < chart_.series.size(); ++i) {
      canvas_.SetColor(SeriesColor(i));
      canvas_.Text(FigureRight(i), kTop - 20, chart_.series[i], 1);
    }
  }

  void DrawRow(const DotChart::Row& row, double y) {
    canvas_.SetColor(kChartInk);
    canvas_.SetTextHeight(13);
    canvas_.Text(40, y, row.label);
    for (std::size_t i = 0; i < row.values.size(); ++i) {
      canvas_.SetColor(SeriesColor(i));
      canvas_.SetTextHeight(13);
      canvas_.Text(FigureRight(i), y, Figure(row.values[i]), 1);
      if (!row.values[i] || !(*row.values[i] > 0)) continue;
      canvas_.SetTextHeight(18);
      canvas_.Marker(XOf(std::log10(*row.values[i])), y, PlotCanvas::MarkerShape::kCircle);
    }
  }

  const DotChart& chart_;
  AxisRange range_;
  PlotCanvas canvas_;
};

}  // namespace

Image<Rgb8> DrawDotChart(const DotChart& chart) {
  const int width =
      kLabelWidth + kPlotWidth + 30 + kFigureWidth * static_cast<int>(chart.series.size());
  const int height = kTop + kBottom + kRowHeight * RowCount(chart) +
                     kGroupSpace * static_cast<int>(chart.groups.size());
  Image<Rgb8> image(width, height, kChartPaper);
  ChartDrawing(chart, &image).Draw();
  return image;
}

}  // namespace surfit
