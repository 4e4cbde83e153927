#include "pictures/equal_aspect.h"

#include <algorithm>
#include <cmath>

namespace surfit {
namespace {

double UnitsPerPixel(const AxisRange& range, double side_px) {
  constexpr double kFilled = 0.9, kShortest_m = 1e-3;
  return std::max(std::abs(range.end - range.begin), kShortest_m) / (kFilled * side_px);
}

AxisRange Widened(const AxisRange& range, double length) {
  const double center = (range.begin + range.end) / 2;
  const double half = range.end < range.begin ? -length / 2 : length / 2;
  return {center - half, center + half};
}

}  // namespace

AxisRanges EqualAspect(const AxisRanges& ranges, double box_width_px, double box_height_px) {
  const double units_per_pixel =
      std::max(UnitsPerPixel(ranges.x, box_width_px), UnitsPerPixel(ranges.y, box_height_px));
  return {Widened(ranges.x, units_per_pixel * box_width_px),
          Widened(ranges.y, units_per_pixel * box_height_px)};
}

}  // namespace surfit
