#pragma once

#include <cstddef>
#include <vector>

#include "surfit/core/image.h"
#include "surfit/frame/camera_motion.h"
#include "surfit/frame/preprocess.h"
#include "surfit/frame/rgbd_frame.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/geometry/trajectory.h"

namespace surfit {

// Applied rolling-shutter correction: rows were moved to the middle of the readout, with this
// camera motion.
struct KeyframeReadout {
  CameraMotion motion;
  double readout_s = 0;
};

// Images of one frame for refinement, all of one size. They do not depend on the estimated
// calibration.
struct KeyframeImages {
  Image<float> inverse_depth;  // 1/m, as measured; 0: missing
  // Slopes of inverse depth along rows and columns, 1/m per px. NaN: missing.
  Image<float> slope_u, slope_v;
  DepthNoise noise;
  Image<float> intensity;  // in [0, 1], smoothed; NaN: unknown; empty without colour
  KeyframeReadout readout;
};

// Keyframe for Refine().
struct RefinementKeyframe {
  Rigid3d world_from_camera;  // at the middle of the readout
  KeyframeImages images;
};

// Computes the images of a frame at the middle of its readout. PreprocessOptions::pyramid_levels
// has no effect. `motion`: camera motion during the readout. The images must have the size of
// `sensor.camera`; colour may be empty. Slopes follow from the normals of preprocessing: n_x / (fx
// d) per column and n_y / (fy d) per row, with the plane n . X = d. Inverse depth is not filtered,
// so that its errors are independent per pixel.
KeyframeImages MakeKeyframeImages(const RgbdFrame& frame, const DepthSensor& sensor,
                                  const CameraMotion& motion, const PreprocessOptions& options);

// Returns whether the motion between two poses exceeds the translation or the rotation.
bool HasMoved(const Rigid3d& a, const Rigid3d& b, double min_translation_m,
              double min_rotation_rad);

// Returns the ascending indices of keyframes in `trajectory`: the first pose, and each pose that
// HasMoved() since the last keyframe. Both thresholds grow until there are at most `max_count`
// keyframes; 0: no limit. With a limit, both thresholds must be positive. This is not checked: with
// a threshold of 0, the function may not return. Empty for an empty trajectory.
std::vector<std::size_t> ChooseKeyframes(const Trajectory& trajectory, double min_translation_m,
                                         double min_rotation_rad, std::size_t max_count);

// Moves a trajectory with its keyframes. `keyframes`: ascending indices of poses.
// `world_from_keyframe`: their new poses. A frame moves rigidly with the keyframe before and with
// the keyframe after the frame. The two results are interpolated by time, which must increase:
// translation linearly, rotation by slerp. Frames before the first or after the last keyframe move
// with this keyframe. Throws if there are no keyframes, or if the sizes differ. Indices are not
// checked.
Trajectory CorrectTrajectory(const Trajectory& trajectory,
                             const std::vector<std::size_t>& keyframes,
                             const std::vector<Rigid3d>& world_from_keyframe);

}  // namespace surfit
