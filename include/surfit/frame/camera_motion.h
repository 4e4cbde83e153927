#pragma once

#include <Eigen/Core>

#include "surfit/geometry/rigid3.h"
#include "surfit/geometry/trajectory.h"

namespace surfit {

// Angular and linear velocity of a camera, in the camera frame. A static point X moves by -(angular
// velocity x X + velocity) per second in this frame.
struct CameraMotion {
  Eigen::Vector3d angular_velocity_rad_per_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_m_per_s = Eigen::Vector3d::Zero();

  bool IsZero() const { return angular_velocity_rad_per_s.isZero(0) && velocity_m_per_s.isZero(0); }
};

// Constant velocity of a camera that moves from the first to the second pose in `seconds`. The
// vectors are in the camera frame at half of the rotation, which is at most 180 degrees. Zero if
// seconds <= 0.
CameraMotion MotionOver(const Rigid3d& first_from_second, double seconds);

// Velocity at the pose with the time `stamp_s` (within 1e-5 s), by MotionOver() from its previous
// to its next pose. The pose itself replaces a missing neighbour. Neighbours more than max_gap_s
// from the pose are missing. The trajectory must be ascending, which is not checked. Zero without a
// pose at this time, and without neighbours.
CameraMotion MotionAt(const Trajectory& trajectory, double stamp_s, double max_gap_s = 0.1);

}  // namespace surfit
