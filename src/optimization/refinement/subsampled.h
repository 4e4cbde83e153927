#pragma once

#include "surfit/optimization/refine.h"

namespace surfit {

// Returns the calibration of an image with every stride-th column and row. stride >= 1.
DepthCalibration Subsampled(DepthCalibration calibration, int stride);

// Converts the calibration and its covariance in `summary` from subsampled images to the whole
// images of the camera `whole`. `stride` as in Subsampled().
void ScaleUp(const PinholeCamera& whole, int stride, RefinementSummary* summary);

}  // namespace surfit
