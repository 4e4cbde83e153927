#include "tracking/motion/motion_prior.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "registration/solvers/decompositions.h"
#include "surfit/registration/normal_system.h"

namespace surfit {
namespace {

constexpr double kTurn_rad_per_s = 1.5, kSpeed_m_per_s = 3;

}  // namespace

ExpectedPose In(const Rigid3d& new_from_old_target, const ExpectedPose& expected) {
  const Matrix6d transform = IncrementTransform(new_from_old_target);
  return {new_from_old_target * expected.target_from_source,
          transform * expected.covariance * transform.transpose()};
}

ExpectedPose MostLikely(const ExpectedPose& expected, const Rigid3d& registered,
                        const Matrix6d& information, double most_sigmas) {
  const Vector6d motion = FirstOrderIncrement(expected.target_from_source, registered);
  const Matrix6d of_expected = SymmetricInverse(expected.covariance);
  const std::optional<GeneralizedEigen> both = EigenOf(information, of_expected);
  if (!both) return expected;
  const Vector6d away = both->vectors.transpose() * (of_expected * motion);
  Vector6d worth, way;
  for (int i = 0; i < 6; ++i) {
    worth[i] = std::max(0., both->values[i]);
    const double sigmas = std::abs(away[i]) / most_sigmas;
    if (sigmas > 1) worth[i] = std::min(worth[i], 1 / (sigmas * sigmas - 1));
    way[i] = worth[i] / (1 + worth[i]) * away[i];
  }
  const Vector6d left = (1 + worth.array()).inverse();
  return {LeftIncrement<double>(both->vectors * way, expected.target_from_source),
          both->vectors * left.asDiagonal() * both->vectors.transpose()};
}

double SquaredDifference(const ExpectedPose& expected, const Rigid3d& registered,
                         const Matrix6d& information) {
  const Vector6d motion = FirstOrderIncrement(expected.target_from_source, registered);
  const Matrix6d of_expected = SymmetricInverse(expected.covariance);
  const std::optional<GeneralizedEigen> both = EigenOf(information, of_expected);
  if (!both) return std::numeric_limits<double>::infinity();
  const Vector6d away = both->vectors.transpose() * (of_expected * motion);
  double sum = 0;
  for (int i = 0; i < 6; ++i) {
    const double worth = std::max(0., both->values[i]);
    sum += away[i] * away[i] * worth / (1 + worth);
  }
  return sum;
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
