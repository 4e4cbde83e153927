// Tests of the comparison of two calibrations, and of scaling a calibration to full resolution.
#include <gtest/gtest.h>

#include "optimization/refinement/joint_state.h"
#include "optimization/refinement/subsampled.h"

namespace surfit::testing {
namespace {

PinholeCamera WholeCamera() { return {320, 240, 260, 250, 159.5, 119.5, {}}; }

// The squared Mahalanobis distance of n parameters has the mean n and the variance 2 n
// (chi-square).
TEST(CalibrationChange, LimitIsMeanPlusStandardDeviations) {
  EXPECT_DOUBLE_EQ((CalibrationChange{0, 8}.Limit(0)), 8);
  EXPECT_DOUBLE_EQ((CalibrationChange{0, 8}.Limit(3)), 8 + 3 * 4);
}

// The errors of the focal lengths are two sigmas and one sigma. Parameters without variance are
// fixed.
TEST(CalibrationChange, CountsEstimatedParameters) {
  const DepthCalibration given = {WholeCamera(), {}, 0};
  DepthCalibration found = given;
  found.camera.fx += 2;
  found.camera.fy -= 3;
  found.camera.cx += 100;
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(kCalibrationSize, kCalibrationSize);
  covariance(0, 0) = 1;
  covariance(1, 1) = 9;
  const CalibrationChange change = ChangeOf(found, given, covariance);
  EXPECT_EQ(change.free, 2);
  EXPECT_NEAR(change.squared_distance, 4 + 1, 1e-12);
}

// At every second pixel, the parameters in px are halved. The scale multiplies covariances of px
// and inverse depth, and its square multiplies variances of px.
TEST(ScaleUp, ScalesPixelsAndCovariance) {
  constexpr int kStride = 2;
  RefinementSummary summary;
  summary.calibration = Subsampled({WholeCamera(), {}, 0.01}, kStride);
  EXPECT_EQ(summary.calibration.camera.fx, WholeCamera().fx / kStride);
  summary.calibration_covariance = Eigen::MatrixXd::Ones(kCalibrationSize, kCalibrationSize);
  ScaleUp(WholeCamera(), kStride, &summary);
  const PinholeCamera& camera = summary.calibration.camera;
  EXPECT_EQ(camera.width, WholeCamera().width);
  EXPECT_EQ(camera.height, WholeCamera().height);
  EXPECT_EQ(camera.fx, WholeCamera().fx);
  EXPECT_EQ(camera.fy, WholeCamera().fy);
  EXPECT_EQ(camera.cx, WholeCamera().cx);
  EXPECT_EQ(camera.cy, WholeCamera().cy);
  for (int i = 0; i < kCalibrationSize; ++i) {
    for (int j = 0; j < kCalibrationSize; ++j) {
      const int scale = (i < 4 ? kStride : 1) * (j < 4 ? kStride : 1);
      EXPECT_EQ(summary.calibration_covariance(i, j), scale) << i << " " << j;
    }
  }
}

}  // namespace
}  // namespace surfit::testing
