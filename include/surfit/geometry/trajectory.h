#pragma once

#include <optional>
#include <vector>

#include "surfit/geometry/rigid3.h"

namespace surfit {

// A camera pose with its time: x_world = world_from_camera * x_camera.
struct StampedPose {
  double stamp_s = 0;
  Rigid3d world_from_camera;
};

// Poses in ascending order of time.
using Trajectory = std::vector<StampedPose>;

// The pose at a time between two poses at most max_gap_s apart: translation linear, rotation along
// the shortest arc. Elsewhere that of a pose at most max_difference_s away, or nothing.
std::optional<Rigid3d> InterpolatePose(const Trajectory& trajectory, double stamp_s,
                                       double max_gap_s = 0.1, double max_difference_s = 0.02);

// Positions in two lists of stamps.
struct StampMatch {
  int first = 0;
  int second = 0;
};

// Pairs of stamps at most max_difference_s apart, both lists ascending: the nearest pair of all is
// taken first, and no stamp twice (associate.py of the TUM RGB-D benchmark, but for the limit
// itself, which matches here as in evo). Ascending in both.
std::vector<StampMatch> MatchStamps(const std::vector<double>& first_s,
                                    const std::vector<double>& second_s, double max_difference_s);

}  // namespace surfit
