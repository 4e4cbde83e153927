#include "apps/export/color_lens.h"

#include <gmock/gmock.h>

#include <vector>

#include "testing/matchers.h"

namespace surfit::testing {
namespace {

// freiburg1 of TUM.
const PinholeCamera kCamera = {
    640, 480, 517.3, 516.5, 318.6, 255.3, {0.2624, -0.9531, -0.0054, 0.0026, 1.1633}};

TEST(ColorLens, DerivativesAreThoseOfFiniteDifferences) {
  const Eigen::Vector3d point(0.4, -0.3, 1.3);
  const auto seen = ProjectByLens(kCamera, point);
  ASSERT_TRUE(seen);
  constexpr double kStep = 1e-6;
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(k);
    const Eigen::Vector2d difference = (ProjectByLens(kCamera, point + step)->pixel -
                                        ProjectByLens(kCamera, point - step)->pixel) /
                                       (2 * kStep);
    EXPECT_THAT(seen->by_point.col(k), VectorNear(difference, 1e-5));
  }
}

TEST(ColorLens, RayIsTheInverseOfTheProjection) {
  const std::vector<Eigen::Vector2d> pixels = {{0, 0}, {639, 0}, {100, 470}, {318.6, 255.3}};
  for (const Eigen::Vector2d& pixel : pixels) {
    const auto ray = RayOfLens(kCamera, pixel.x(), pixel.y());
    ASSERT_TRUE(ray);
    EXPECT_THAT(ProjectByLens(kCamera, *ray)->pixel, VectorNear(pixel, 1e-5));
  }
  EXPECT_FALSE(ProjectByLens(kCamera, {0, 0, -1}));
}

TEST(ColorLens, UndistortedImagesHaveNoEmptyPixels) {
  const PinholeCamera undistorted = UndistortedCamera(kCamera);
  EXPECT_FALSE(undistorted.HasDistortion());
  const Image<Rgb8> image = Undistort(Image<Rgb8>(640, 480, {9, 8, 7}), kCamera, undistorted);
  for (const Rgb8 pixel : image) ASSERT_EQ(pixel, (Rgb8{9, 8, 7}));
  EXPECT_NEAR(undistorted.fx, kCamera.fx, 60);
}

}  // namespace
}  // namespace surfit::testing
