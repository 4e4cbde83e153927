#include "pictures/trajectory_axes.h"

namespace surfit {

std::array<ShownAxes, 2> ChooseTrajectoryAxes(const Eigen::Vector3d& up,
                                              const Eigen::Vector3d& extent_m) {
  int vertical;
  up.cwiseAbs().maxCoeff(&vertical);
  const bool downward = up[vertical] < 0;
  // In cyclic order the cross product of the two others is the vertical axis.
  const int next = (vertical + 1) % 3, last = (vertical + 2) % 3;
  const int right = downward ? last : next, away = downward ? next : last;
  const int longer = extent_m[right] >= extent_m[away] ? right : away;
  return {ShownAxes{"from above", right, away, false},
          ShownAxes{"from the side", longer, vertical, downward}};
}

}  // namespace surfit
