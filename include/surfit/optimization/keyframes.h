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

// How the rows of a rolling shutter's image were brought to the middle of its readout: by the
// camera's motion, as if that took so long.
struct KeyframeReadout {
  CameraMotion motion;
  double readout_s = 0;
};

// One frame's images as refinement needs them, all of one size: none depends on the calibration,
// but for its readout as given.
struct KeyframeImages {
  Image<float> inverse_depth;  // 1/m, as measured; 0 = missing
  Image<float> slope_u,
      slope_v;             // of inverse depth along rows and columns, 1/m per px; NaN = missing
  DepthNoise noise;        // of the depth
  Image<float> intensity;  // from 0 to 1, smoothed; NaN where unknown; empty without colours
  KeyframeReadout readout;
};

// A frame whose pose is refined.
struct RefinementKeyframe {
  Rigid3d world_from_camera;
  KeyframeImages images;
};

// The images of a frame of that sensor, as of the middle of its readout while the camera moved so.
// The slopes are those of the surface that the normals of
// preprocessing tell, over a window: with the plane n . X = d, 1/z = n . ray / d, so that 1/z
// grows by n_x / (fx d) per column and n_y / (fy d) per row. Inverse depth itself is not filtered:
// the errors of its pixels are independent, as the covariance takes them to be, and nothing is
// smoothed where a surface bends.
KeyframeImages MakeKeyframeImages(const RgbdFrame& frame, const DepthSensor& sensor,
                                  const CameraMotion& motion, const PreprocessOptions& options);

// Whether the camera has moved from one pose to the other by more than these.
bool HasMoved(const Rigid3d& a, const Rigid3d& b, double min_translation_m,
              double min_rotation_rad);

// Which poses of a trajectory become keyframes: the first, and each that has moved from the last
// keyframe by more than one of the two. With more than max_count (0 = no limit) both are enlarged
// until there are no more. Ascending.
std::vector<std::size_t> ChooseKeyframes(const Trajectory& trajectory, double min_translation_m,
                                         double min_rotation_rad, std::size_t max_count);

// A trajectory moved along with some of its poses: between two keyframes each pose is what both of
// them, moved, make of it, interpolated by time; beyond the last keyframe it moves with that.
// keyframes are ascending indices, not empty; world_from_keyframe their new poses.
Trajectory CorrectTrajectory(const Trajectory& trajectory,
                             const std::vector<std::size_t>& keyframes,
                             const std::vector<Rigid3d>& world_from_keyframe);

}  // namespace surfit
