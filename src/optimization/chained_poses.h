#pragma once

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

}  // namespace surfit
