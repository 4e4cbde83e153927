#include "tracking/motion/motion_prior.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "registration/solvers/decompositions.h"

namespace surfit {
namespace {

constexpr double kTurn_rad_per_s = 1.5, kSpeed_m_per_s = 3;

}  // namespace

ExpectedPose In(const Rigid3d& new_from_old_target, const ExpectedPose& expected) {
  const Matrix6d transform = IncrementTransform(new_from_old_target);
  return {new_from_old_target * expected.target_from_source,
          transform * expected.covariance * transform.transpose()};
}

Matrix6d PoseComparison::Along(const Vector6d& factors) const {
  const Matrix6d scaled = inverse_covariance * vectors;
  return scaled * factors.asDiagonal() * scaled.transpose();
}

std::optional<PoseComparison> Compare(const ExpectedPose& expected, const Rigid3d& registered,
                                      const Matrix6d& information, double most_sigmas) {
  const Vector6d motion = FirstOrderIncrement(expected.target_from_source, registered);
  PoseComparison comparison;
  comparison.inverse_covariance = SymmetricInverse(expected.covariance);
  const std::optional<GeneralizedEigen> both = EigenOf(information, comparison.inverse_covariance);
  if (!both) return std::nullopt;
  comparison.vectors = both->vectors;
  comparison.weights = both->values.cwiseMax(0);
  comparison.differences = both->vectors.transpose() * (comparison.inverse_covariance * motion);
  for (int i = 0; i < 6; ++i) {
    const double sigmas = std::abs(comparison.differences[i]) / most_sigmas;
    if (sigmas > 1) {
      comparison.weights[i] = std::min(comparison.weights[i], 1 / (sigmas * sigmas - 1));
    }
  }
  return comparison;
}

// Gauss-Newton. The error decreases by the rotation between both poses in each step: 1e-2 rad gives
// 1e-12 after six steps.
ExpectedPose MostLikely(const ExpectedPose& expected, const Rigid3d& registered,
                        const Matrix6d& information, double most_sigmas) {
  constexpr int kSteps = 6;
  const std::optional<PoseComparison> both =
      Compare(expected, registered, information, most_sigmas);
  if (!both) return expected;
  const PriorTerm terms[] = {{expected.target_from_source, both->inverse_covariance},
                             {registered, both->Along(both->weights)}};
  Rigid3d pose = expected.target_from_source;
  for (int step = 0; step < kSteps; ++step) {
    Matrix6d hessian = Matrix6d::Zero();
    Vector6d right_side = Vector6d::Zero();
    for (const PriorTerm& term : terms) {
      const PriorRows rows = term.RowsAt(pose);
      hessian += rows.leftCols<6>().transpose() * rows.leftCols<6>();
      right_side -= rows.leftCols<6>().transpose() * rows.col(6);
    }
    pose = LeftIncrement<double>(SolveLdlt(hessian, right_side), pose);
  }
  const Vector6d left = (1 + both->weights.array()).inverse();
  return {pose, both->vectors * left.asDiagonal() * both->vectors.transpose()};
}

std::optional<PriorTerm> InUnitsOf(const Matrix6d& hessian, const ExpectedPose& expected,
                                   const Rigid3d& registered, const Matrix6d& information,
                                   double most_sigmas) {
  // Bounds the factor of a direction without information.
  constexpr double kLeastWeight = 1e-6;
  const std::optional<PoseComparison> both =
      Compare(expected, registered, information, most_sigmas);
  if (!both) return std::nullopt;
  Vector6d factors;
  for (int i = 0; i < 6; ++i) {
    const auto column = both->vectors.col(i);
    factors[i] = (std::max(0., column.dot(hessian * column)) + kLeastWeight) /
                 (both->weights[i] + kLeastWeight);
  }
  return PriorTerm{expected.target_from_source, both->Along(factors)};
}

double SquaredDifference(const ExpectedPose& expected, const Rigid3d& registered,
                         const Matrix6d& information) {
  const std::optional<PoseComparison> both =
      Compare(expected, registered, information, std::numeric_limits<double>::infinity());
  if (!both) return std::numeric_limits<double>::infinity();
  const Vector6d& weights = both->weights;
  return (both->differences.array().square() * weights.array() / (1 + weights.array())).sum();
}

MotionPrior::MotionPrior(double acceleration_m_per_s2, double angular_acceleration_rad_per_s2)
    : of_acceleration_(Variances(angular_acceleration_rad_per_s2, acceleration_m_per_s2)) {}

void MotionPrior::Keep(const Matrix6d& covariance, double seconds) {
  of_velocity_ = covariance / (seconds * seconds);
}

Matrix6d MotionPrior::Covariance(double seconds) const {
  const Matrix6d of_velocity = of_velocity_.value_or(Variances(kTurn_rad_per_s, kSpeed_m_per_s));
  return seconds * seconds * (of_velocity + seconds * seconds * of_acceleration_);
}

}  // namespace surfit
