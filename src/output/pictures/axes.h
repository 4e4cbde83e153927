#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "output/pictures/canvas.h"

namespace surfit {

// Values at the left (lower) and at the right (upper) end of an axis. begin > end reverses the
// axis.
struct AxisRange {
  double begin, end;
};

struct AxisRanges {
  AxisRange x, y;
};

// Widens the ranges about their centres to the same number of units per pixel on both axes of a
// box. One of the given ranges fills 90 % of its side, the other one less. Directions are kept.
// Ranges below 1 mm are treated as 1 mm.
AxisRanges EqualAspect(const AxisRanges& ranges, double box_width_px, double box_height_px);

// Colour of ticks and labels.
inline constexpr Rgb8 kAxisInk = {40, 40, 40};

// At most `most` round numbers in the range, ascending, with steps of 1, 2 or 5 times a power of
// ten.
std::vector<double> RoundTicks(AxisRange range, int most);
// Ticks from low to high, 0 < low. The ticks are powers of ten, and for ranges below two decades
// also 2 and 5 times the powers of ten.
std::vector<double> LogarithmicTicks(double low, double high);
// Text of a tick with up to 6 digits.
std::string TickText(double value);

// Axes of a chart: the box in the image in px, and the values at its edges.
struct Axes {
  PixelBox box;
  AxisRanges ranges;
  std::string title, x_label, y_label;

  PixelPoint At(double x, double y) const;
};

// Draws the frame with grid and numbers. Title and y label are above the frame, the x label is
// below.
void DrawAxes(Image<Rgb8>* image, const Axes& axes);

// World axes of a view of a path: 0, 1, 2 for x, y, z.
struct ShownAxes {
  std::string title;
  int horizontal, vertical;
  bool vertical_downward;  // coordinates increase downwards in the picture
};

// A view from above and a view from the side, for the world axis nearest to `up`. Both views are
// right-handed: right x up points to the viewer. In the view from above, `up` points to the viewer.
// The view from the side shows the horizontal axis with the larger extent, and `up` is upwards.
std::array<ShownAxes, 2> ChooseTrajectoryAxes(const Eigen::Vector3d& up,
                                              const Eigen::Vector3d& extent_m);

}  // namespace surfit
