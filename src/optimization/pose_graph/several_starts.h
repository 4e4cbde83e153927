#pragma once

#include <vector>

#include "optimization/pose_graph/optimize_pose_graph.h"

namespace surfit {

// Result of one method and one start.
struct GraphAttempt {
  PoseGraphSummary summary;
  std::vector<Rigid3d> world_from_pose;
};

// Runs one method, which is not "auto", from one start.
GraphAttempt OptimizeOnce(const PoseGraph& graph, const PoseGraphOptions& options,
                          const ChainedPoses& chained);

// Sets poses and costs of the attempt.
void Finish(const PoseGraph& graph, const PoseGraphOptions& options,
            const PoseGraphProblem& problem, GraphAttempt* attempt);

// Runs "gnc" from odometry and chordal poses, or all methods of "auto", and returns the best
// attempt. Costs are compared with limits of squared errors that follow from the residuals: see
// PoseGraphSummary::loop_error_limit.
GraphAttempt OptimizeFromSeveralStarts(const PoseGraph& graph, const PoseGraphOptions& options,
                                       const ChainedPoses& chained);

}  // namespace surfit
