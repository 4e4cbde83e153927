#include "surfit/evaluation/absolute_trajectory_error.h"

namespace surfit {

std::optional<AbsoluteTrajectoryError> ComputeAbsoluteTrajectoryError(
    const std::vector<MatchedPose>& poses) {
  std::vector<Eigen::Vector3d> estimate, ground_truth;
  for (const MatchedPose& pose : poses) {
    estimate.push_back(pose.estimate.translation);
    ground_truth.push_back(pose.ground_truth.translation);
  }
  AbsoluteTrajectoryError ate;
  ate.alignment = AlignPoints(estimate, ground_truth);
  if (ate.alignment.status == AlignmentStatus::kTooFewPoints) return std::nullopt;
  std::vector<double> errors_m;
  for (std::size_t i = 0; i < estimate.size(); ++i) {
    const Eigen::Vector3d aligned = ate.alignment.target_from_source * estimate[i];
    errors_m.push_back((ground_truth[i] - aligned).norm());
  }
  ate.translation_m = Summarize(std::move(errors_m));
  return ate;
}

}  // namespace surfit
