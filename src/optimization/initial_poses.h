#pragma once

#include <optional>
#include <vector>

#include "surfit/optimization/pose_graph.h"

namespace surfit {

// Poses along a spanning forest of the graph.
struct ChainedPoses {
  std::vector<Rigid3d> world_from_pose;
  // Those where trees begin, which the gauge's freedom is taken from: all fixed poses, and the
  // first of each part of the graph that has none.
  std::vector<bool> held;
};

// Chains measurements from held poses on, along loops only where no odometry leads.
ChainedPoses ChainPoses(const PoseGraph& graph);

// Poses from two linear systems, whatever the drift: rotations R_i that minimise the sum of
// k |R_b - R_a R_ab|^2 over all edges as if they were any matrices, made rotations afterwards, then
// translations that minimise the sum of k' |t_b - t_a - R_a t_ab|^2; k, k' are the mean information
// of rotation and translation. Held poses stay. Nothing where a system cannot be solved. Carlone et
// al.: Initialization techniques for 3D SLAM, ICRA 2015, IV.B.
std::optional<std::vector<Rigid3d>> ChordalPoses(const PoseGraph& graph,
                                                 const std::vector<bool>& held);

}  // namespace surfit
