#include "optimization/refinement/subsampled.h"

namespace surfit {

DepthCalibration Subsampled(DepthCalibration calibration, int stride) {
  calibration.camera = calibration.camera.Subsampled(stride);
  return calibration;
}

void ScaleUp(const PinholeCamera& whole, int stride, RefinementSummary* summary) {
  PinholeCamera& camera = summary->calibration.camera;
  camera.width = whole.width;
  camera.height = whole.height;
  for (double* px : {&camera.fx, &camera.fy, &camera.cx, &camera.cy}) *px *= stride;
  if (Eigen::MatrixXd& covariance = summary->calibration_covariance; covariance.size() > 0) {
    covariance.topRows<4>() *= stride;
    covariance.leftCols<4>() *= stride;
  }
}

}  // namespace surfit
