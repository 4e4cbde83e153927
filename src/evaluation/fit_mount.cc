#include <Eigen/Eigenvalues>
#include <cmath>

#include "surfit/core/error.h"
#include "surfit/evaluation/trajectory_evaluation.h"

namespace surfit {
namespace {

// Unknowns: left rotation increment, translation, mount, log of the scale.
constexpr int kUnknowns = 10;
constexpr int kScale = 9;
using Vector = Eigen::Matrix<double, kUnknowns, 1>;
using Matrix = Eigen::Matrix<double, kUnknowns, kUnknowns>;

constexpr int kMaxIterations = 100;
constexpr double kConverged = 1e-12;  // length of the last increment, m and rad
// Minimum eigenvalue of an observable direction, relative to the largest. Real paths have more
// than 1e-8 in all directions, because of millimetre noise.
constexpr double kInformationTolerance = 1e-10;

struct Fit {
  Rigid3d true_from_estimated;
  Eigen::Vector3d mount_m = Eigen::Vector3d::Zero();
  double scale = 1;
};

Eigen::Vector3d Predicted(const Fit& fit, const Rigid3d& estimate) {
  return fit.true_from_estimated *
         (fit.scale * estimate.translation + estimate.rotation * fit.mount_m);
}

Eigen::Matrix3d CrossProduct(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

struct NormalEquations {
  Matrix h = Matrix::Zero();
  Vector g = Vector::Zero();
};

// Rotations are about `center`, to decouple them from the translation.
NormalEquations Linearize(const Fit& fit, const Eigen::Vector3d& center, bool fit_scale,
                          const std::vector<MatchedPose>& poses) {
  NormalEquations normal;
  for (const MatchedPose& pose : poses) {
    const Eigen::Vector3d predicted = Predicted(fit, pose.estimate);
    const Eigen::Quaterniond& rotation = fit.true_from_estimated.rotation;
    Eigen::Matrix<double, 3, kUnknowns> j = Eigen::Matrix<double, 3, kUnknowns>::Zero();
    j.leftCols<3>() = -CrossProduct(predicted - center);
    j.middleCols<3>(3).setIdentity();
    j.middleCols<3>(6) = (rotation * pose.estimate.rotation).toRotationMatrix();
    if (fit_scale) j.col(kScale) = rotation * (fit.scale * pose.estimate.translation);
    normal.h += j.transpose() * j;
    normal.g += j.transpose() * (pose.ground_truth.translation - predicted);
  }
  return normal;
}

struct Step {
  Vector increment = Vector::Zero();
  bool is_unique = true;
};

// Minimum-norm step: zero along unobservable directions.
Step Solve(const NormalEquations& normal, bool fit_scale) {
  const int unknowns = fit_scale ? kUnknowns : kScale;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(
      normal.h.topLeftCorner(unknowns, unknowns));
  const Eigen::VectorXd& values = eigen.eigenvalues();
  const Eigen::VectorXd projected = eigen.eigenvectors().transpose() * normal.g.head(unknowns);
  Step step;
  for (int i = 0; i < unknowns; ++i) {
    if (values[i] > kInformationTolerance * values[unknowns - 1]) {
      step.increment.head(unknowns) += projected[i] / values[i] * eigen.eigenvectors().col(i);
    } else {
      step.is_unique = false;
    }
  }
  return step;
}

void Apply(const Vector& increment, const Eigen::Vector3d& center, Fit* fit) {
  const double angle = increment.head<3>().norm();
  Rigid3d turn;
  if (angle > 0) turn.rotation = Eigen::AngleAxisd(angle, increment.head<3>() / angle);
  turn.translation = center - turn.rotation * center + increment.segment<3>(3);
  fit->true_from_estimated = turn * fit->true_from_estimated;
  fit->mount_m += increment.segment<3>(6);
  fit->scale *= std::exp(increment[kScale]);
}

}  // namespace

std::optional<MountFit> FitMount(const std::vector<MatchedPose>& poses, bool fit_scale) {
  const auto plain = ComputeAbsoluteTrajectoryError(poses);
  if (!plain) return std::nullopt;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  for (const MatchedPose& pose : poses) center += pose.ground_truth.translation;
  center /= static_cast<double>(poses.size());
  Fit fit;
  fit.true_from_estimated = plain->alignment.target_from_source;
  Step step;
  for (int i = 0; i < kMaxIterations; ++i) {
    step = Solve(Linearize(fit, center, fit_scale, poses), fit_scale);
    Apply(step.increment, center, &fit);
    if (step.increment.norm() < kConverged) break;
  }
  MountFit result;
  result.true_body_in_estimated_m = fit.mount_m;
  result.scale = fit.scale;
  result.is_unique = step.is_unique;
  result.ate.alignment = {AlignmentStatus::kAligned, fit.true_from_estimated};
  std::vector<double> errors_m;
  for (const MatchedPose& pose : poses) {
    errors_m.push_back((pose.ground_truth.translation - Predicted(fit, pose.estimate)).norm());
  }
  result.ate.translation_m = Summarize(std::move(errors_m));
  return result;
}

std::string MountWarning(const MountFit& fit) {
  constexpr double kLimit_m = 0.05;
  const double length_m = fit.true_body_in_estimated_m.norm();
  if (length_m <= kLimit_m && fit.is_unique) return "";
  if (!fit.is_unique) {
    return "fit_mount: the camera rotates too little to determine the mount, or moves along a line";
  }
  return Concat("fit_mount: the fitted mount is ", length_m, " m long, above ", kLimit_m,
                " m: it can hide errors of the poses");
}

}  // namespace surfit
