#include <gtest/gtest.h>

#include "surfit/core/error.h"
#include "surfit/geometry/inverse_depth_field.h"
#include "surfit/geometry/sensor.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

PinholeCamera TestCamera() { return {641, 480, 500, 510, 320.5, 239, {}}; }

TEST(PinholeCamera, RayInvertsProject) {
  const PinholeCamera camera = TestCamera();
  const Eigen::Vector3d point(0.3, -0.4, 2.5);
  const Eigen::Vector2d uv = camera.Project(point);
  EXPECT_DOUBLE_EQ(uv.x(), 500 * 0.3 / 2.5 + 320.5);
  EXPECT_LT((2.5 * camera.Ray(uv.x(), uv.y()) - point).norm(), 1e-12);
}

TEST(PinholeCamera, SubsampledPixelHasRayOfKeptPixel) {
  const PinholeCamera camera = TestCamera();
  const PinholeCamera third = camera.Subsampled(3);
  EXPECT_EQ(third.width, 214);
  EXPECT_EQ(third.height, 160);
  EXPECT_LT((third.Ray(10, 20) - camera.Ray(30, 60)).norm(), 1e-12);
}

TEST(PinholeCamera, BinnedPixelHasRayOfBlockCentre) {
  const PinholeCamera camera = TestCamera();
  const PinholeCamera half = camera.Binned(2);
  EXPECT_EQ(half.width, 320);
  EXPECT_EQ(half.height, 240);
  EXPECT_LT((half.Ray(10, 20) - camera.Ray(20.5, 40.5)).norm(), 1e-12);
}

TEST(PinholeCamera, ValidateRejectsInvalidFieldsByName) {
  PinholeCamera camera = TestCamera();
  EXPECT_NO_THROW(camera.Validate("x"));
  camera.fx = -5;
  testing::ExpectInputError([&] { camera.Validate("camera.yaml"); },
                            testing::Names("camera.yaml", "fx", -5));
  camera = TestCamera();
  camera.fy = -480;  // image y up: a convention, not an error
  EXPECT_NO_THROW(camera.Validate("x"));
  camera.width = 0;
  EXPECT_THROW(camera.Validate("x"), InputError);
}

// Depth edges need positive bounds along both image axes. Sources mirror such images.
TEST(DepthSensor, RejectsNegativeFy) {
  DepthSensor sensor = {TestCamera(), {}};
  EXPECT_NO_THROW(sensor.Validate());
  sensor.camera.fy = -480;
  testing::ExpectInputError([&] { sensor.Validate(); }, testing::Names("sensor", "fy", -480));
}

TEST(RgbdCamera, ValidateChecksColorCameraOnlyIfUnregistered) {
  RgbdCamera camera;
  camera.depth = TestCamera();
  EXPECT_NO_THROW(camera.Validate("x"));
  camera.color_is_registered = false;
  EXPECT_THROW(camera.Validate("x"), InputError);
  camera.color = TestCamera();
  EXPECT_NO_THROW(camera.Validate("x"));
  camera.depth_units_per_metre = 0;
  EXPECT_THROW(camera.Validate("x"), InputError);
}

const InverseDepthField kField = {{-0.01, 0.02, -0.03, 0.04, 0.05, -0.06}};

TEST(InverseDepthField, EvaluatesPolynomialOfRay) {
  const double x = 0.3, y = -0.4;
  EXPECT_NEAR(kField.At(x, y),
              -0.01 + 0.02 * x - 0.03 * y + 0.04 * x * x + 0.05 * x * y - 0.06 * y * y, 1e-15);
}

TEST(InverseDepthField, AddsToInverseDepth) {
  const InverseDepthField offset = {{0.02 / 3}};
  EXPECT_FLOAT_EQ(offset.Corrected(3, 0.1, 0.2), 3 / 1.02);
  EXPECT_EQ(offset.Corrected(0, 0.1, 0.2), 0);
  EXPECT_EQ(InverseDepthField{{-0.5}}.Corrected(3, 0.1, 0.2), 0);  // no positive depth
}

TEST(Recalibrated, KeepsPixelAndMeasuredDepth) {
  const DepthCalibration a = {{640, 480, 520, 515, 318, 241, {}}, kField};
  const DepthCalibration b = {{640, 480, 530, 531, 325, 236, {}}, {{0.02, -0.01, 0, 0.01, 0, 0}}};
  const double u = 100, v = 400;
  const float measured_m = 2.5;
  const auto point_of = [&](const DepthCalibration& calibration) {
    const Eigen::Vector3d ray = calibration.camera.Ray(u, v);
    return Eigen::Vector3d(ray * calibration.field.Corrected(measured_m, ray.x(), ray.y()));
  };
  EXPECT_LT((Recalibrated(point_of(a), a, b) - point_of(b)).norm(), 1e-6);
  EXPECT_LT((Recalibrated(point_of(a), a, a) - point_of(a)).norm(), 1e-14);
}

TEST(InverseDepthField, SubstitutedAgreesAtTransformedRays) {
  const double x_scale = 0.9, x_shift = 0.02, y_scale = 1.2, y_shift = -0.1;
  const InverseDepthField other = kField.Substituted(x_scale, x_shift, y_scale, y_shift);
  for (const double x : {-0.5, 0.2}) {
    for (const double y : {-0.3, 0.4}) {
      EXPECT_NEAR(other.At(x, y), kField.At(x_scale * x + x_shift, y_scale * y + y_shift), 1e-15);
    }
  }
}

TEST(InverseDepthField, MirroredAgreesAtMirroredRays) {
  EXPECT_NEAR(Mirrored(kField).At(0.3, -0.2), kField.At(0.3, 0.2), 1e-15);
}

}  // namespace
}  // namespace surfit::testing
