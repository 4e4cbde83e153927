#include "surfit/evaluation/trajectory_evaluation.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "surfit/core/error.h"
#include "surfit/core/options.h"

namespace surfit {
namespace {

// Collinear points: maximum ratio of the second and the first singular value of the
// cross-covariance. Straight lines have 1e-16, real paths with millimetre noise 1e-8.
constexpr double kRankTolerance = 1e-12;

Eigen::Vector3d Mean(const std::vector<Eigen::Vector3d>& points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& point : points) sum += point;
  return sum / static_cast<double>(points.size());
}

using Unit = RelativePoseErrorOptions::Unit;

constexpr double kDegreesPerRadian = 57.295779513082320877;
constexpr double kSecondsTolerance = 0.1;  // relative to delta

std::size_t FindNearest(const std::vector<MatchedPose>& poses, double stamp_s) {
  const auto after =
      std::lower_bound(poses.begin(), poses.end(), stamp_s,
                       [](const MatchedPose& pose, double stamp) { return pose.stamp_s < stamp; });
  if (after == poses.begin()) return 0;
  const auto before = after - 1;
  const bool take_before =
      after == poses.end() || stamp_s - before->stamp_s <= after->stamp_s - stamp_s;
  return (take_before ? before : after) - poses.begin();
}

// Index of the pose at the interval delta after pose i.
std::optional<std::size_t> FindPartner(const std::vector<MatchedPose>& poses, std::size_t i,
                                       const RelativePoseErrorOptions& options) {
  if (options.delta_unit == Unit::kFrames) {
    const std::size_t j = i + static_cast<std::size_t>(options.delta);
    return j < poses.size() ? std::make_optional(j) : std::nullopt;
  }
  const double wanted_s = poses[i].stamp_s + options.delta;
  const std::size_t j = FindNearest(poses, wanted_s);
  if (std::abs(poses[j].stamp_s - wanted_s) > kSecondsTolerance * options.delta) {
    return std::nullopt;
  }
  return j;
}

std::optional<Rigid3d> TruthAt(const Trajectory& ground_truth, double stamp_s,
                               const MatchOptions& options) {
  return InterpolatePose(ground_truth, stamp_s, options.max_gap_s, options.max_difference_s);
}

Rigid3d RelativeError(const MatchedPose& i, const MatchedPose& j) {
  const Rigid3d true_motion = i.ground_truth.Inverse() * j.ground_truth;
  const Rigid3d estimated_motion = i.estimate.Inverse() * j.estimate;
  return true_motion.Inverse() * estimated_motion;
}

}  // namespace

// For centred points, R maximises tr(R^T C) with C = sum target_i source_i^T = U D V^T. The
// maximum over rotations is R = U S V^T with S = diag(1, 1, det U det V). R is unique if d_2 +
// s_3 d_3 > 0.
Alignment AlignPoints(const std::vector<Eigen::Vector3d>& source,
                      const std::vector<Eigen::Vector3d>& target) {
  ThrowIf(source.size() != target.size(), "there are ", source.size(), " source and ",
          target.size(), " target points, must be equal");
  Alignment alignment;
  if (source.size() < 3) return alignment;
  const Eigen::Vector3d source_mean = Mean(source), target_mean = Mean(target);
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < source.size(); ++i) {
    covariance += (target[i] - target_mean) * (source[i] - source_mean).transpose();
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  ThrowIf(svd.info() != Eigen::Success,
          "a position is not finite, so the alignment has no solution");
  const Eigen::Matrix3d &u = svd.matrixU(), &v = svd.matrixV();
  const Eigen::Vector3d& d = svd.singularValues();
  const Eigen::Vector3d s(1, 1, u.determinant() * v.determinant() < 0 ? -1 : 1);
  const Eigen::Matrix3d rotation = u * s.asDiagonal() * v.transpose();
  alignment.target_from_source = Rigid3d(rotation, target_mean - rotation * source_mean);
  alignment.status = d[1] + s[2] * d[2] > kRankTolerance * d[0]
                         ? AlignmentStatus::kAligned
                         : AlignmentStatus::kRotationNotUnique;
  return alignment;
}

std::vector<MatchedPose> MatchPoses(const Trajectory& ground_truth, const Trajectory& estimate,
                                    const MatchOptions& options) {
  Validate(options);
  std::vector<MatchedPose> poses;
  for (const StampedPose& pose : estimate) {
    const std::optional<Rigid3d> truth = TruthAt(ground_truth, pose.stamp_s, options);
    if (truth) poses.push_back({pose.stamp_s, *truth, pose.world_from_camera});
  }
  return poses;
}

std::vector<double> Stamps(const Trajectory& trajectory) {
  std::vector<double> stamps;
  stamps.reserve(trajectory.size());
  for (const StampedPose& pose : trajectory) stamps.push_back(pose.stamp_s);
  return stamps;
}

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

PoseError ErrorOf(const Rigid3d& estimated, const Rigid3d& truth) {
  const Rigid3d difference = truth.Inverse() * estimated;
  return {difference.translation.norm(), RotationAngle(difference.rotation) * 180 / M_PI};
}

std::optional<RelativePoseError> ComputeRelativePoseError(const std::vector<MatchedPose>& poses,
                                                          const RelativePoseErrorOptions& options) {
  Validate(options);
  std::vector<double> translations_m, rotations_deg;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const auto j = FindPartner(poses, i, options);
    if (!j) continue;
    const Rigid3d error = RelativeError(poses[i], poses[*j]);
    translations_m.push_back(error.translation.norm());
    rotations_deg.push_back(RotationAngle(error.rotation) * kDegreesPerRadian);
  }
  if (translations_m.empty()) return std::nullopt;
  return RelativePoseError{Summarize(std::move(translations_m)),
                           Summarize(std::move(rotations_deg))};
}

TrajectoryEvaluation EvaluateTrajectory(const Trajectory& ground_truth, const Trajectory& estimate,
                                        const std::vector<double>& frame_stamps_s,
                                        const TrajectoryEvaluationOptions& options) {
  const auto poses = MatchPoses(ground_truth, estimate, options.match);
  TrajectoryEvaluation evaluation;
  evaluation.matched = static_cast<int>(poses.size());
  for (const double stamp_s : frame_stamps_s) {
    evaluation.expected += TruthAt(ground_truth, stamp_s, options.match).has_value();
  }
  if (evaluation.expected > 0) {
    evaluation.coverage =
        std::min(1., static_cast<double>(evaluation.matched) / evaluation.expected);
  }
  evaluation.ate = ComputeAbsoluteTrajectoryError(poses);
  evaluation.rpe = ComputeRelativePoseError(poses, options.rpe);
  return evaluation;
}

}  // namespace surfit
