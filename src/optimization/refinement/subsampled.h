#pragma once

#include "surfit/optimization/refine.h"

namespace surfit {

// A calibration as it is for every stride-th column and row.
DepthCalibration Subsampled(DepthCalibration calibration, int stride);

// What was found for these, as it is for the whole images that camera has.
void ScaleUp(const PinholeCamera& whole, int stride, RefinementSummary* summary);

}  // namespace surfit
