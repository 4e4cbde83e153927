#pragma once

#include <cstddef>
#include <vector>

#include "surfit/geometry/trajectory.h"

namespace surfit {

// Which poses of a trajectory become keyframes: the first, and each that has moved from the last
// keyframe by more than one of the two. With more than max_count (0 = no limit) both are enlarged
// until there are no more. Ascending.
std::vector<std::size_t> ChooseKeyframes(const Trajectory& trajectory, double min_translation_m,
                                         double min_rotation_rad, std::size_t max_count);

// A trajectory moved along with some of its poses: between two keyframes each pose is what both of
// them, moved, make of it, interpolated by time; beyond the last keyframe it moves with that.
// keyframes are ascending indices, not empty; world_from_keyframe their new poses.
Trajectory CorrectTrajectory(const Trajectory& trajectory,
                             const std::vector<std::size_t>& keyframes,
                             const std::vector<Rigid3d>& world_from_keyframe);

}  // namespace surfit
