#include "surfit/evaluation/trajectory_evaluation.h"

#include <algorithm>

#include "surfit/geometry/match_stamps.h"

namespace surfit {

TrajectoryEvaluation EvaluateTrajectory(const Trajectory& ground_truth, const Trajectory& estimate,
                                        const std::vector<double>& frame_stamps_s,
                                        const TrajectoryEvaluationOptions& options) {
  const auto poses = MatchPoses(ground_truth, estimate, options.match);
  const auto expected =
      MatchStamps(frame_stamps_s, Stamps(ground_truth), options.match.max_difference_s);
  TrajectoryEvaluation evaluation;
  evaluation.expected = static_cast<int>(expected.size());
  evaluation.matched = static_cast<int>(poses.size());
  if (!expected.empty()) {
    evaluation.coverage = std::min(1., static_cast<double>(poses.size()) / expected.size());
  }
  evaluation.ate = ComputeAbsoluteTrajectoryError(poses);
  evaluation.rpe = ComputeRelativePoseError(poses, options.rpe);
  return evaluation;
}

}  // namespace surfit
