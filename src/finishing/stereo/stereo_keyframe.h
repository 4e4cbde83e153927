#pragma once

#include <cstdint>

#include "surfit/core/image.h"
#include "surfit/frame/camera_motion.h"
#include "surfit/frame/rgbd_frame.h"
#include "surfit/geometry/pinhole_camera.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/geometry/sensor.h"

namespace surfit {

// Small global-shutter image of a frame with its measured depth.
struct StereoKeyframe {
  int index = 0;              // frame index
  PinholeCamera camera;       // of both images
  Rigid3d world_from_camera;  // at the middle of the readout of the colour image
  Image<Rgb8> color;          // (0, 0, 0): not visible to the colour camera
  Image<float> measured_m;    // z, m; 0: no measured depth
};

// Makes a keyframe with at least 320 columns, or all columns of smaller images. `frame` has been
// corrected by EstimatedSensor::Correct(), `depth_m` is its depth without rolling shutter.
// The poses are those at RgbdFrame::stamp_s and RgbdFrame::color_stamp_s. The rotation of the
// camera during the readout of the colour image is corrected.
StereoKeyframe MakeStereoKeyframe(const RgbdFrame& frame, const Image<float>& depth_m,
                                  const DepthSensor& sensor, const CameraMotion& motion,
                                  const Rigid3d& world_from_camera,
                                  const Rigid3d& world_from_color);

// Brightness of an image, 0 to 255.
Image<std::uint8_t> Brightness(const Image<Rgb8>& color);

}  // namespace surfit
