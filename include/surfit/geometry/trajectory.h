#pragma once

#include <optional>
#include <vector>

#include "surfit/geometry/rigid3.h"

namespace surfit {

// Camera pose at a time: x_world = world_from_camera * x_camera, m.
struct StampedPose {
  double stamp_s = 0;  // of a frame: capture time of the depth image
  Rigid3d world_from_camera;
};

// Poses in ascending order of time. Functions with a trajectory require this order, which is not
// checked.
using Trajectory = std::vector<StampedPose>;

// Pose at a time. Interpolates between two poses at most max_gap_s apart: translation linearly,
// rotation by slerp. Otherwise, returns the nearest pose within max_difference_s, or std::nullopt.
// The later pose is returned if both are equally near. At the time of a pose, returns this pose. An
// empty trajectory gives std::nullopt. max_gap_s = 0: no interpolation.
std::optional<Rigid3d> InterpolatePose(const Trajectory& trajectory, double stamp_s,
                                       double max_gap_s = 0.1, double max_difference_s = 0.02);

// Indices of two matching timestamps.
struct StampMatch {
  int first = 0;
  int second = 0;
};

// Matches two ascending lists of timestamps, in s, as associate.py of the TUM RGB-D benchmark does.
// The closest pair is matched first; each timestamp is used at most once. Differences up to and
// including max_difference_s match, like in evo. The order of the lists is not checked. Equal
// differences are matched in the order of `first`. Matches that cross exchange their partners, in
// contrast to associate.py. The result is therefore ascending in `first` and in `second`. Empty for
// an empty list.
std::vector<StampMatch> MatchStamps(const std::vector<double>& first_s,
                                    const std::vector<double>& second_s, double max_difference_s);

}  // namespace surfit
