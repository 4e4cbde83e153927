#pragma once

#include <optional>

#include "surfit/geometry/rigid3.h"
#include "surfit/registration/normal_system.h"

namespace surfit {

// Where a camera is expected, and the covariance of the left increment (rad, m) from there to where
// it is.
struct ExpectedPose {
  Rigid3d target_from_source;
  Matrix6d covariance;
};

// The same in another frame.
ExpectedPose In(const Rigid3d& new_from_old_target, const ExpectedPose& expected);

// Registration found a pose, with some information I on the left increment. The most likely one,
// given both, P the expected one's covariance: along columns v with V^T P^-1 V = 1 and
// V^T I V = diag(w), it goes w / (1 + w) of the way z from the expected pose, and 1 / (1 + w) of
// the variance is left (a Kalman filter's update). By what both say, z has the variance 1 + 1 / w.
// Where it is more than so many standard deviations, registration is surer than it can be, and w is
// taken as small as makes it that many.
ExpectedPose MostLikely(const ExpectedPose& expected, const Rigid3d& registered,
                        const Matrix6d& information, double most_sigmas);

// What is known of a camera's steady motion, and how surely: a Kalman filter over its velocity,
// which random accelerations change.
class MotionPrior {
 public:
  MotionPrior(double acceleration_m_per_s2, double turn_acceleration_rad_per_s2);

  // The camera may have moved in any way.
  void Forget() { of_velocity_.reset(); }
  // It has moved within so many seconds, by a motion of this covariance in the camera's frame.
  void Keep(const Matrix6d& covariance, double seconds);
  // Of the motion within the next seconds; of any motion of a hand where nothing is known.
  Matrix6d Covariance(double seconds) const;

 private:
  Matrix6d of_acceleration_;             // covariance, (rad/s^2)^2 and (m/s^2)^2
  std::optional<Matrix6d> of_velocity_;  // likewise, (rad/s)^2 and (m/s)^2
};

}  // namespace surfit
