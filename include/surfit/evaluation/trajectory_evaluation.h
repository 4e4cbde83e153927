#pragma once

#include <optional>
#include <vector>

#include "surfit/evaluation/absolute_trajectory_error.h"
#include "surfit/evaluation/matched_poses.h"
#include "surfit/evaluation/relative_pose_error.h"
#include "surfit/geometry/trajectory.h"

namespace surfit {

// How a trajectory is compared with the ground truth.
struct TrajectoryEvaluationOptions {
  MatchOptions match;
  RelativePoseErrorOptions rpe;
};

// What is said of an estimated trajectory.
struct TrajectoryEvaluation {
  int expected = 0;  // frames that should have a pose: those that the ground truth knows
  int matched = 0;   // poses of the estimate that the ground truth knows
  // matched / expected, at most 1; 0 if nothing is expected. An error over few poses says little.
  double coverage = 0;
  std::optional<AbsoluteTrajectoryError> ate;
  std::optional<RelativePoseError> rpe;
};

// All that is said of an estimated trajectory. frame_stamps_s are the stamps of all frames that the
// estimate was to have a pose for, ascending.
// Throws InputError if the options are not valid.
TrajectoryEvaluation EvaluateTrajectory(const Trajectory& ground_truth, const Trajectory& estimate,
                                        const std::vector<double>& frame_stamps_s,
                                        const TrajectoryEvaluationOptions& options);

}  // namespace surfit
