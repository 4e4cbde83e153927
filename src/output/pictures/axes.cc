#include "output/pictures/axes.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace surfit {
namespace {

constexpr Rgb8 kGrid = {225, 225, 225};

double UnitsPerPixel(const AxisRange& range, double side_px) {
  constexpr double kFilled = 0.9, kShortest_m = 1e-3;
  return std::max(std::abs(range.end - range.begin), kShortest_m) / (kFilled * side_px);
}

AxisRange Widened(const AxisRange& range, double length) {
  const double center = (range.begin + range.end) / 2;
  const double half = range.end < range.begin ? -length / 2 : length / 2;
  return {center - half, center + half};
}

double RoundStep(double least) {
  const double power = std::pow(10, std::floor(std::log10(least)));
  for (const double factor : {1, 2, 5}) {
    if (factor * power >= least * (1 - 1e-9)) return factor * power;
  }
  return 10 * power;
}

}  // namespace

AxisRanges EqualAspect(const AxisRanges& ranges, double box_width_px, double box_height_px) {
  const double units_per_pixel =
      std::max(UnitsPerPixel(ranges.x, box_width_px), UnitsPerPixel(ranges.y, box_height_px));
  return {Widened(ranges.x, units_per_pixel * box_width_px),
          Widened(ranges.y, units_per_pixel * box_height_px)};
}

std::vector<double> RoundTicks(AxisRange range, int most) {
  const double low = std::min(range.begin, range.end), high = std::max(range.begin, range.end);
  std::vector<double> ticks;
  if (!(high > low)) return ticks;
  const double step = RoundStep((high - low) / most);
  // rounding errors must not remove ticks at the ends
  const double slack = 1e-9 * (high - low) / step;
  for (double k = std::ceil(low / step - slack); k <= high / step + slack; ++k) {
    ticks.push_back(k * step + 0.);  // turns -0 into 0
  }
  return ticks;
}

std::vector<double> LogarithmicTicks(double low, double high) {
  const bool is_long = high >= 100 * low;
  std::vector<double> ticks;
  for (double power = std::pow(10, std::floor(std::log10(low))); power <= high; power *= 10) {
    for (const double factor : {1, 2, 5}) {
      const double value = factor * power;
      if (value >= low && value <= high && (factor == 1 || !is_long)) ticks.push_back(value);
    }
  }
  return ticks;
}

std::string TickText(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.6g", value);
  return text;
}

PixelPoint Axes::At(double x, double y) const {
  const AxisRange &h = ranges.x, &v = ranges.y;
  return {box.left + (box.right - box.left) * (x - h.begin) / (h.end - h.begin),
          box.bottom + (box.top - box.bottom) * (y - v.begin) / (v.end - v.begin)};
}

void DrawAxes(Image<Rgb8>* image, const Axes& axes) {
  constexpr double kSpacing_px = 75;
  constexpr TextStyle kNumber = {15, 0.5, kAxisInk}, kLabel = {17, 0.5, kAxisInk};
  const PixelBox& box = axes.box;
  const int columns = static_cast<int>((box.right - box.left) / kSpacing_px);
  const int rows = static_cast<int>((box.bottom - box.top) / kSpacing_px);
  for (const double x : RoundTicks(axes.ranges.x, columns)) {
    const double u = axes.At(x, 0).u;
    DrawLine(image, {{u, box.top}, {u, box.bottom}}, kGrid, 1);
    DrawText(image, {u, box.bottom + 16}, TickText(x), kNumber);
  }
  for (const double y : RoundTicks(axes.ranges.y, rows)) {
    const double v = axes.At(0, y).v;
    DrawLine(image, {{box.left, v}, {box.right, v}}, kGrid, 1);
    DrawText(image, {box.left - 10, v}, TickText(y), {kNumber.height_px, 1, kAxisInk});
  }
  DrawLine(image,
           {{box.left, box.top},
            {box.right, box.top},
            {box.right, box.bottom},
            {box.left, box.bottom},
            {box.left, box.top}},
           kAxisInk, 1);
  const double middle = (box.left + box.right) / 2;
  DrawText(image, {middle, box.top - 20}, axes.title, {20, 0.5, kAxisInk});
  DrawText(image, {middle, box.bottom + 42}, axes.x_label, kLabel);
  DrawText(image, {box.left, box.top - 20}, axes.y_label, {kLabel.height_px, 0, kAxisInk});
}

std::array<ShownAxes, 2> ChooseTrajectoryAxes(const Eigen::Vector3d& up,
                                              const Eigen::Vector3d& extent_m) {
  int vertical;
  up.cwiseAbs().maxCoeff(&vertical);
  const bool downward = up[vertical] < 0;
  // cyclic order of the axes, so that both views are right-handed
  const int next = (vertical + 1) % 3, last = (vertical + 2) % 3;
  const int right = downward ? last : next, away = downward ? next : last;
  const int longer = extent_m[right] >= extent_m[away] ? right : away;
  return {ShownAxes{"from above", right, away, false},
          ShownAxes{"from the side", longer, vertical, downward}};
}

}  // namespace surfit
