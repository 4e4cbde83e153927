#pragma once

#include "surfit/geometry/inverse_depth_field.h"
#include "surfit/geometry/pinhole_camera.h"

namespace surfit {

// What self-calibration may change of an undistorted depth camera.
struct DepthCalibration {
  PinholeCamera camera;  // size in px, fx fy cx cy; no distortion
  InverseDepthField field;
};

}  // namespace surfit
