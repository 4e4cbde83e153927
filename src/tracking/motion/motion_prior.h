#pragma once

#include <optional>

#include "surfit/geometry/rigid3.h"
#include "surfit/registration/normal_system.h"
#include "surfit/registration/pose_solver.h"

namespace surfit {

// Predicted pose with the covariance of its left perturbation (rad, m).
struct ExpectedPose {
  Rigid3d target_from_source;
  Matrix6d covariance;
};

// Transforms a predicted pose into another target frame. `new_from_old_target` maps the old target
// frame to the new one. The covariance is transformed as well.
ExpectedPose In(const Rigid3d& new_from_old_target, const ExpectedPose& expected);

// Comparison of a predicted pose (covariance P) with a registered pose (information I of the left
// perturbation). Both poses have the same frames. The columns of V satisfy V^T P^-1 V = 1 and V^T I
// V = diag(w).
struct PoseComparison {
  Matrix6d inverse_covariance;  // P^-1
  Matrix6d vectors;             // V
  Vector6d weights;             // w, at least 0
  Vector6d differences;         // of both poses along the columns of V, in sigmas of P

  // Sum of V diag(factors) V^T, in the units of P^-1.
  Matrix6d Along(const Vector6d& factors) const;
};
// The variance of a difference z is 1 + 1 / w. If z exceeds `most_sigmas` standard deviations, the
// registration is overconfident: w is reduced until z is within this bound. Infinity: no bound.
// std::nullopt if a matrix is not finite, or if P is not positive definite.
std::optional<PoseComparison> Compare(const ExpectedPose& expected, const Rigid3d& registered,
                                      const Matrix6d& information, double most_sigmas);

// Most likely pose by a predicted and a registered pose, and its covariance. It minimises the sum
// of both squared errors of cost_functions/pose_prior.h. Arguments as in Compare(). Directions
// without information keep the predicted pose.
ExpectedPose MostLikely(const ExpectedPose& expected, const Rigid3d& registered,
                        const Matrix6d& information, double most_sigmas);

// Predicted pose as a prior in the units of the normal equations. `hessian`: that of the normal
// equations at the registered pose. Neighbouring points share errors, so the information I is less
// than the Hessian. The ratio of prior and Hessian is that of P^-1 and I along each column of V.
// Arguments and empty result as in Compare().
std::optional<PriorTerm> InUnitsOf(const Matrix6d& hessian, const ExpectedPose& expected,
                                   const Rigid3d& registered, const Matrix6d& information,
                                   double most_sigmas);

// Uncertainty of a predicted motion and of the registration that it is combined with.
struct MotionUncertainty {
  // rad, m; of the predicted motion, in the camera frame
  Matrix6d covariance = Matrix6d::Zero();
  // Factors of the standard deviations of the registration (rad, m).
  Vector6d registration_scale = Vector6d::Ones();
  // Covariance (rad, m) of errors of the registered pose that its information does not contain, in
  // the camera frame.
  Matrix6d registration_noise = Matrix6d::Zero();
  // Maximum difference of the registration, in standard deviations: see MostLikely().
  // std::nullopt: only weakly constrained registrations have a maximum.
  std::optional<double> max_sigmas;
  // The prediction changes the poses of weakly constrained frames only.
  bool holds_weak_frames_only = false;

  // Only inertial predictions have noise of the registration.
  bool IsInertial() const { return !registration_noise.isZero(0); }
};

// Squared difference of a predicted and a registered pose in standard deviations. It has a
// chi-square distribution with the rank of the information as degrees of freedom. Directions
// without information do not count. Infinite if a matrix is not finite.
double SquaredDifference(const ExpectedPose& expected, const Rigid3d& registered,
                         const Matrix6d& information);

// Constant-velocity motion prior: a Kalman filter over the camera velocity with random
// accelerations.
class MotionPrior {
 public:
  // Standard deviations of the accelerations, per axis.
  MotionPrior(double acceleration_m_per_s2, double angular_acceleration_rad_per_s2);

  // Makes the velocity unknown.
  void Forget() { of_velocity_.reset(); }
  // Sets the velocity covariance from the covariance of the last motion (rad, m), in the camera
  // frame, and its duration. Requires seconds > 0.
  void Keep(const Matrix6d& covariance, double seconds);
  // Covariance (rad, m) of the motion in the next `seconds`, in the camera frame. An unknown
  // velocity has the standard deviations 1.5 rad/s and 3 m/s, which are typical of hand motion.
  Matrix6d Covariance(double seconds) const;

 private:
  Matrix6d of_acceleration_;             // covariance, (rad/s^2)^2 and (m/s^2)^2
  std::optional<Matrix6d> of_velocity_;  // covariance, (rad/s)^2 and (m/s)^2
};

}  // namespace surfit
