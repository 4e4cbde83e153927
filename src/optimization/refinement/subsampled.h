#pragma once

#include "surfit/optimization/refine.h"

namespace surfit {

// Returns the calibration of an image with every stride-th column and row.
DepthCalibration Subsampled(DepthCalibration calibration, int stride);

// Converts the calibration of subsampled images to the whole images of a camera.
void ScaleUp(const PinholeCamera& whole, int stride, RefinementSummary* summary);

}  // namespace surfit
