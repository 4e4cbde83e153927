#pragma once

#include "surfit/frame/camera_motion.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/frame/rgbd_frame.h"
#include "surfit/geometry/sensor.h"

namespace surfit {

// Converts a rolling-shutter frame to a global-shutter frame at the middle of the readout. Row v of
// h rows is read at tau = ((v + 0.5) / h - 0.5) readout_s after the middle. With constant motion, a
// point X of this row has this position at the middle of the readout:
//   X + tau (turn x X + velocity).
// An output pixel gets colour and depth of the nearest pixel that moves to it. Colour is registered
// to depth, or empty. Depth is extrapolated along the surface, except at depth edges. Pixels
// without depth move as points at infinity. turn and velocity: members of `motion`. Colour without
// a source pixel is (0, 0, 0), depth is 0. Returns the input frame if the readout or the motion is
// 0.
RgbdFrame CorrectRollingShutter(const RgbdFrame& frame, const DepthSensor& sensor,
                                const CameraMotion& motion);

// Correction of a pose for the error of the predicted motion during the readout.
// CorrectRollingShutter() has used the motion m = `expected`. The registered pose gives the motion
// m' = `found` since the last frame, `seconds` (positive) earlier. The error m' - m displaces each
// point X by tau (m' - m)(X). The corrected points change the pose, and thus m'. The consistent
// pose is world_from_camera * exp(d) with
//   (A + B / seconds) d = -B (m' - m),   A = sum w a a^T,  B = sum w tau a a^T,  a = (X x n, n),
// and weights w = 1 / sigma_z^2, summed over the pixels whose normal n faces the camera. Returns
// exp(d), or the identity if d is not finite or the matrix is singular (pivots below 1e-10 of the
// largest). The result is inaccurate along weakly constrained directions.
Rigid3d ReadoutCorrection(const FrameLevel& surface, double readout_s, const CameraMotion& expected,
                          const CameraMotion& found, double seconds);

}  // namespace surfit
