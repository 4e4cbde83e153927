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

// Rolling-shutter correction of an image: rows were moved to the middle of the readout by this
// camera motion and readout time.
struct KeyframeReadout {
  CameraMotion motion;
  double readout_s = 0;
};

// Images of one frame for refinement, all of one size. They do not depend on the calibration,
// except on the input readout.
struct KeyframeImages {
  Image<float> inverse_depth;  // 1/m, as measured; 0: missing
  // Slopes of inverse depth along rows and columns, 1/m per px. NaN: missing.
  Image<float> slope_u, slope_v;
  DepthNoise noise;
  Image<float> intensity;  // in [0, 1], smoothed; NaN: unknown; empty without colour
  KeyframeReadout readout;
};

// Keyframe with a pose to refine.
struct RefinementKeyframe {
  Rigid3d world_from_camera;
  KeyframeImages images;
};

// Computes the images of a frame at the middle of its readout. `motion` is the camera motion at
// that time. The slopes follow from the normals of preprocessing, which use a window. With the
// plane n . X = d and 1/z = n . ray / d, 1/z grows by n_x / (fx d) per column and n_y / (fy d) per
// row. Inverse depth is not filtered: its errors stay independent per pixel, as the covariance
// assumes, and curved surfaces are not smoothed.
KeyframeImages MakeKeyframeImages(const RgbdFrame& frame, const DepthSensor& sensor,
                                  const CameraMotion& motion, const PreprocessOptions& options);

// Returns whether the motion between two poses exceeds the translation or the rotation.
bool HasMoved(const Rigid3d& a, const Rigid3d& b, double min_translation_m,
              double min_rotation_rad);

// Returns the ascending indices of keyframes: the first pose, and each pose that HasMoved() since
// the last keyframe. If there are more than `max_count` (0: no limit), both thresholds grow until
// there are at most `max_count`.
std::vector<std::size_t> ChooseKeyframes(const Trajectory& trajectory, double min_translation_m,
                                         double min_rotation_rad, std::size_t max_count);

// Moves a trajectory with its keyframes. A pose between two keyframes moves with both, and both
// results are interpolated by time. A pose after the last keyframe moves with that keyframe.
// `keyframes` are ascending indices with the new poses `world_from_keyframe`. Aborts if they are
// empty or have different sizes.
Trajectory CorrectTrajectory(const Trajectory& trajectory,
                             const std::vector<std::size_t>& keyframes,
                             const std::vector<Rigid3d>& world_from_keyframe);

}  // namespace surfit
