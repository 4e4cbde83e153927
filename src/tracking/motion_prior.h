#pragma once

#include <optional>

#include "surfit/geometry/rigid3.h"
#include "surfit/registration/normal_system.h"

namespace surfit {

// Predicted pose, and the covariance of the left perturbation (rad, m) from it to the true pose.
struct ExpectedPose {
  Rigid3d target_from_source;
  Matrix6d covariance;
};

// Transforms a predicted pose into another target frame.
ExpectedPose In(const Rigid3d& new_from_old_target, const ExpectedPose& expected);

// Combines a predicted pose and a registered pose, with the information I of the left perturbation:
// the update of a Kalman filter. P is the covariance of the predicted pose. Along the columns v of
// V with V^T P^-1 V = 1 and V^T I V = diag(w), the result moves by w / (1 + w) of the distance z
// between both poses. 1 / (1 + w) of the variance remains.
//
// z has the variance 1 + 1 / w. If z exceeds `most_sigmas` standard deviations, the registration is
// overconfident: w is reduced until z is within this bound.
//
// Returns the predicted pose if the information is not finite, or if P is not positive definite.
ExpectedPose MostLikely(const ExpectedPose& expected, const Rigid3d& registered,
                        const Matrix6d& information, double most_sigmas);

// Constant-velocity motion prior: a Kalman filter over the camera velocity with random
// accelerations.
class MotionPrior {
 public:
  MotionPrior(double acceleration_m_per_s2, double angular_acceleration_rad_per_s2);

  // Resets the velocity to unknown.
  void Forget() { of_velocity_.reset(); }
  // Sets the covariance of the last motion, in the camera frame, and its duration.
  void Keep(const Matrix6d& covariance, double seconds);
  // Covariance of the motion in the next `seconds`. An unknown velocity has the covariance of hand
  // motion.
  Matrix6d Covariance(double seconds) const;

 private:
  Matrix6d of_acceleration_;             // covariance, (rad/s^2)^2 and (m/s^2)^2
  std::optional<Matrix6d> of_velocity_;  // covariance, (rad/s)^2 and (m/s)^2
};

}  // namespace surfit
