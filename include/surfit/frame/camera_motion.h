#pragma once

#include <Eigen/Core>

#include "surfit/geometry/rigid3.h"
#include "surfit/geometry/trajectory.h"

namespace surfit {

// How a camera moves, as it sees it itself: a point X that stands still moves by
// -(turn x X + velocity) a second.
struct CameraMotion {
  Eigen::Vector3d turn_rad_per_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_m_per_s = Eigen::Vector3d::Zero();

  bool IsZero() const { return turn_rad_per_s.isZero(0) && velocity_m_per_s.isZero(0); }
};

// The steady motion that takes the camera from one pose to the next within so many seconds; none
// unless these are positive.
CameraMotion MotionOver(const Rigid3d& first_from_second, double seconds);

// The motion along a trajectory at the time of one of its poses: from the pose before to the one
// after, of which both, or one, are at most max_gap_s away; else none.
CameraMotion MotionAt(const Trajectory& trajectory, double stamp_s, double max_gap_s = 0.1);

}  // namespace surfit
