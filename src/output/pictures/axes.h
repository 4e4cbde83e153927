#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "output/pictures/canvas.h"

namespace surfit {

// Values from the left (lower) edge of an axis to the right (upper) one; begin > end turns it.
struct AxisRange {
  double begin, end;
};

struct AxisRanges {
  AxisRange x, y;
};

// Ranges about the centres of the given ones with the same number of units per pixel on both axes
// of a box; at least one of the given ranges fills 90 % of its side, none more. Directions are
// kept; a range shorter than 1 mm counts as 1 mm.
AxisRanges EqualAspect(const AxisRanges& ranges, double box_width_px, double box_height_px);

// Of ticks and labels.
inline constexpr Rgb8 kAxisInk = {40, 40, 40};

// Round numbers in the range, ascending: at most `most`, 1, 2 or 5 times a power of ten apart.
std::vector<double> RoundTicks(AxisRange range, int most);
// Of values from low to high, 0 < low: the powers of ten or, where those are few, also 2 and 5
// times them.
std::vector<double> LogarithmicTicks(double low, double high);
// The shortest text of a tick.
std::string TickText(double value);

// A box of an image in which values are drawn over two axes.
struct Axes {
  PixelBox box;
  AxisRanges ranges;
  std::string title, x_label, y_label;

  PixelPoint At(double x, double y) const;
};

// The frame with a grid and numbers; the title and the label of y stand above it, that of x below.
void DrawAxes(Image<Rgb8>* image, const Axes& axes);

// Which of the world's axes (0, 1, 2 for x, y, z) a drawing of a path shows.
struct ShownAxes {
  std::string title;
  int horizontal, vertical;
  bool vertical_downward;  // coordinates grow down the page
};

// A view from above and one from the side, for the world axis nearest to up. Neither is a mirror
// image: page right x page up points to the reader. From above, that is up, and both axes grow as
// usual; from the side, the page shows the horizontal axis of the larger extent, and up is upwards.
std::array<ShownAxes, 2> ChooseTrajectoryAxes(const Eigen::Vector3d& up,
                                              const Eigen::Vector3d& extent_m);

}  // namespace surfit
