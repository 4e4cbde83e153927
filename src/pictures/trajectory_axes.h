#pragma once

#include <Eigen/Core>
#include <array>
#include <string>

namespace surfit {

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
