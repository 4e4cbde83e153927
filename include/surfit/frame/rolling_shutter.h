#pragma once

#include <Eigen/Core>

#include "surfit/frame/rgbd_frame.h"
#include "surfit/geometry/sensor.h"
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

// The frame as a global shutter would have seen it in the middle of the readout. A rolling shutter
// reads row v of h rows (v + 0.5) / h - 0.5 of the readout later than that, by the time tau. In the
// middle of the readout the point X it sees lies, with a steady motion, at
//   X + tau (turn x X + velocity).
// Each pixel takes the colour and the depth of the nearest pixel that moves there, the depth along
// the surface where that is not an edge. Pixels without depth move as what is far away. The same
// frame without motion or readout.
RgbdFrame AtMiddleOfReadout(const RgbdFrame& frame, const DepthSensor& sensor,
                            const CameraMotion& motion);

}  // namespace surfit
