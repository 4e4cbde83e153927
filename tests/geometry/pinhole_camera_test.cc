#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "surfit/core/error.h"
#include "surfit/geometry/sensor.h"

namespace surfit {
namespace {

PinholeCamera TestCamera() {
  PinholeCamera camera;
  camera.width = 641;
  camera.height = 480;
  camera.fx = 500;
  camera.fy = 510;
  camera.cx = 320.5;
  camera.cy = 239;
  return camera;
}

TEST(PinholeCamera, RayInvertsProject) {
  const PinholeCamera camera = TestCamera();
  const Eigen::Vector3d point(0.3, -0.4, 2.5);
  const Eigen::Vector2d uv = camera.Project(point);
  EXPECT_DOUBLE_EQ(uv.x(), 500 * 0.3 / 2.5 + 320.5);
  EXPECT_LT((2.5 * camera.Ray(uv.x(), uv.y()) - point).norm(), 1e-12);
}

TEST(PinholeCamera, SubsampledPixelSeesTheRayOfTheKeptPixel) {
  const PinholeCamera camera = TestCamera();
  const PinholeCamera third = camera.Subsampled(3);
  EXPECT_EQ(third.width, 214);
  EXPECT_EQ(third.height, 160);
  EXPECT_LT((third.Ray(10, 20) - camera.Ray(30, 60)).norm(), 1e-12);
}

TEST(PinholeCamera, BinnedPixelSeesTheRayOfTheBlocksCentre) {
  const PinholeCamera camera = TestCamera();
  const PinholeCamera half = camera.Binned(2);
  EXPECT_EQ(half.width, 320);
  EXPECT_EQ(half.height, 240);
  EXPECT_LT((half.Ray(10, 20) - camera.Ray(20.5, 40.5)).norm(), 1e-12);
}

TEST(PinholeCamera, ValidateNamesFieldValueAndConstraint) {
  PinholeCamera camera = TestCamera();
  EXPECT_NO_THROW(camera.Validate("x"));
  camera.fx = -5;
  try {
    camera.Validate("camera.yaml");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "camera.yaml: fx is -5, must be finite and positive");
  }
  camera = TestCamera();
  camera.fy = -480;  // image y up: a convention, not an error
  EXPECT_NO_THROW(camera.Validate("x"));
  camera.width = 0;
  EXPECT_THROW(camera.Validate("x"), InputError);
}

TEST(RgbdCamera, ValidateChecksColorOnlyWhereItIsUsed) {
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

}  // namespace
}  // namespace surfit
