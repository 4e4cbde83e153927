#pragma once

#include <vector>

#include "surfit/evaluation/matched_poses.h"

namespace surfit::testing {

// The corners of a square with side 2 m about the origin, in the plane z = 0, looking along z, with
// stamps 0, 1, 2, 3; the estimate is the same but for one corner that is lifted by `lift_m`.
//
// ATE by hand: the errors are 0 but for lift h along z at corner (1, 1). The best rigid motion to
// first order in h is the plane z = a + b x + c y fitted to (0, 0, h, 0) at the corners (x and y
// coordinates change only in second order): a = h/4, b = c = h/4 (sum of h x_i over sum of x_i^2).
// The fit has 3 parameters for 4 values, so what remains is the component along the one contrast
// left, (1, -1, 1, -1)/2: every corner is off by h/4, so that rmse = mean = median = max = h/4.
inline std::vector<MatchedPose> SquareWithALiftedCorner(double lift_m) {
  const Eigen::Vector3d corners[] = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  std::vector<MatchedPose> poses(4);
  for (int i = 0; i < 4; ++i) {
    poses[i].stamp_s = i;
    poses[i].ground_truth.translation = poses[i].estimate.translation = corners[i];
  }
  poses[2].estimate.translation.z() += lift_m;
  return poses;
}

}  // namespace surfit::testing
