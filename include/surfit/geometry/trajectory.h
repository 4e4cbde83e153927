#pragma once

#include <optional>
#include <vector>

#include "surfit/geometry/rigid3.h"

namespace surfit {

// Camera pose with its capture time: x_world = world_from_camera * x_camera.
struct StampedPose {
  double stamp_s = 0;
  Rigid3d world_from_camera;
};

// Poses in ascending order of time.
using Trajectory = std::vector<StampedPose>;

// Pose at a time. Interpolates between two poses at most max_gap_s apart: the translation linearly,
// the rotation by slerp. Otherwise returns the nearest pose at most max_difference_s away, or
// std::nullopt.
std::optional<Rigid3d> InterpolatePose(const Trajectory& trajectory, double stamp_s,
                                       double max_gap_s = 0.1, double max_difference_s = 0.02);

// Indices of two matching timestamps.
struct StampMatch {
  int first = 0;
  int second = 0;
};

// Matches two ascending lists of timestamps. Takes the pair with the smallest difference first, and
// uses each timestamp at most once. The result is ascending in both indices. The method is that of
// associate.py of the TUM RGB-D benchmark, except that a difference of exactly max_difference_s
// matches, like in evo.
std::vector<StampMatch> MatchStamps(const std::vector<double>& first_s,
                                    const std::vector<double>& second_s, double max_difference_s);

}  // namespace surfit
