#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "output/pictures/canvas.h"

namespace surfit {

// Values at the left (lower) and right (upper) end of an axis. begin > end: reversed axis.
struct AxisRange {
  double begin, end;
};

struct AxisRanges {
  AxisRange x, y;
};

// Widens the ranges about their centres, so that both axes have the same number of units per pixel.
// At least one range fills 90 % of its side. Keeps the directions. Ranges below 1 mm are treated as
// 1 mm.
AxisRanges EqualAspect(const AxisRanges& ranges, double box_width_px, double box_height_px);

inline constexpr Rgb8 kAxisInk = {40, 40, 40};

// Ticks in the range, ascending, with steps of 1, 2 or 5 times a power of ten. There are at most
// `most` steps, so most + 1 ticks. Requires most >= 1. Empty for a range of length 0.
std::vector<double> RoundTicks(AxisRange range, int most);
// Ticks from low to high, 0 < low: powers of ten. Ranges below two decades also have ticks at 2 and
// 5.
std::vector<double> LogarithmicTicks(double low, double high);
// Number with at most six significant digits.
std::string TickText(double value);

// Coordinate system in a box of an image. `title` and labels may be empty.
struct Axes {
  PixelBox box;
  AxisRanges ranges;
  std::string title, x_label, y_label;

  // Pixel of a value, also outside of the box. The ranges must not have length 0.
  PixelPoint At(double x, double y) const;
};

// Draws frame, grid, numbers and labels. Title and y label are above the frame, the x label is
// below. The box must have at least 75 px per side, which is not checked.
void DrawAxes(Image<Rgb8>* image, const Axes& axes);

// World axes of a view: 0 is x, 1 is y, 2 is z.
struct ShownAxes {
  std::string title;
  int horizontal, vertical;
  bool vertical_downward;  // coordinates increase downwards
};

// Axes of a view from above and of a view from the side. Both views are right-handed. The view from
// the side shows the horizontal axis with the larger extent. `up`: upward direction in the world
// frame; the nearest world axis is vertical. `extent_m`: size of the path per axis.
std::array<ShownAxes, 2> ChooseTrajectoryAxes(const Eigen::Vector3d& up,
                                              const Eigen::Vector3d& extent_m);

}  // namespace surfit
