#pragma once

#include "surfit/frame/camera_motion.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/frame/rgbd_frame.h"
#include "surfit/geometry/sensor.h"

namespace surfit {

// The frame as a global shutter would have seen it in the middle of the readout. A rolling shutter
// reads row v of h rows (v + 0.5) / h - 0.5 of the readout later than that, by the time tau. In the
// middle of the readout the point X it sees lies, with a steady motion, at
//   X + tau (turn x X + velocity).
// Each pixel takes the colour and the depth of the nearest pixel that moves there, the depth along
// the surface where that is not an edge. Pixels without depth move as what is far away. The same
// frame without motion or readout.
RgbdFrame AtMiddleOfReadout(const RgbdFrame& frame, const DepthSensor& sensor,
                            const CameraMotion& motion);

// By how much the pose of a frame is to change that was brought to the middle of its readout by an
// expected motion m and then registered: by its pose the camera has moved with m' since the last
// frame, `seconds` ago. By m' its points X lie at X + tau (m' - m)(X) instead, and the pose, and m'
// with it, depend on that. All agree at the pose x exp(d) with
//   (A + B / seconds) d = -B (m' - m),   A = sum w a a^T,  B = sum w tau a a^T,  a = (X x n, n),
// points weighted by their noise. Returns exp(d); the identity where the surface does not hold it.
Rigid3d ReadoutCorrection(const FrameLevel& surface, double readout_s, const CameraMotion& expected,
                          const CameraMotion& found, double seconds);

}  // namespace surfit
