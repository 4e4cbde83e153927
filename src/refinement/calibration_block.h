#pragma once

#include <algorithm>

#include "cost_functions/plane_inverse_depth.h"
#include "surfit/refinement/depth_calibration.h"

namespace surfit {

// The calibration as parameter block of kCalibrationSize; the size of the image is left as it is.
inline void CalibrationToBlock(const DepthCalibration& calibration, double* block) {
  const PinholeCamera& camera = calibration.camera;
  block[0] = camera.fx, block[1] = camera.fy, block[2] = camera.cx, block[3] = camera.cy;
  std::copy(calibration.field.coefficients.begin(), calibration.field.coefficients.end(),
            block + kFieldBegin);
}

inline void CalibrationFromBlock(const double* block, DepthCalibration* calibration) {
  PinholeCamera& camera = calibration->camera;
  camera.fx = block[0], camera.fy = block[1], camera.cx = block[2], camera.cy = block[3];
  std::copy(block + kFieldBegin, block + kCalibrationSize, calibration->field.coefficients.begin());
}

}  // namespace surfit
