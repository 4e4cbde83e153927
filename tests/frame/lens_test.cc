#include "frame/lens.h"

#include <gtest/gtest.h>

#include <array>

#include "surfit/geometry/sensor.h"

namespace surfit {
namespace {

PinholeCamera Fr1() {
  return {640, 480, 517.3, 516.5, 318.6, 255.3, {.2624, -.9531, -.0054, .0026, 1.1633}};
}

// One coefficient at a time in OpenCV's order k1 k2 p1 p2 k3, at x = 0.5, y = 0.25, r2 = 0.3125:
// the added displacement, by hand from OpenCV's documentation of camera calibration.
TEST(Lens, EachCoefficientMovesThePixelAsOpenCvDefinesIt) {
  const double r2 = 0.3125;
  const std::array<Eigen::Vector2d, 5> displacements = {
      Eigen::Vector2d(0.5 * r2, 0.25 * r2),
      Eigen::Vector2d(0.5 * r2 * r2, 0.25 * r2 * r2),
      Eigen::Vector2d(2 * 0.5 * 0.25, r2 + 2 * 0.25 * 0.25),
      Eigen::Vector2d(r2 + 2 * 0.5 * 0.5, 2 * 0.5 * 0.25),
      Eigen::Vector2d(0.5 * r2 * r2 * r2, 0.25 * r2 * r2 * r2),
  };
  for (int i = 0; i < 5; ++i) {
    PinholeCamera camera{640, 480, 100, 200, 10, 20, {}};
    camera.distortion[i] = 0.1;
    const LensPixel<double> pixel = Lens<double>(camera).Project(1, 0.5, 2);
    EXPECT_TRUE(pixel.is_seen);
    EXPECT_NEAR(pixel.u, 100 * (0.5 + 0.1 * displacements[i].x()) + 10, 1e-12) << i;
    EXPECT_NEAR(pixel.v, 200 * (0.25 + 0.1 * displacements[i].y()) + 20, 1e-12) << i;
  }
}

TEST(Lens, WithoutDistortionIsProject) {
  PinholeCamera camera = Fr1();
  camera.distortion = {};
  const Eigen::Vector3d point(0.3, -0.2, 1.7);
  const LensPixel<double> pixel = Lens<double>(camera).Project(point);
  EXPECT_LT((Eigen::Vector2d(pixel.u, pixel.v) - camera.Project(point)).norm(), 1e-12);
}

TEST(Lens, SeesNothingBehindTheCamera) {
  EXPECT_FALSE(Lens<double>(Fr1()).Project(0.1, 0.1, 0).is_seen);
  EXPECT_FALSE(Lens<double>(Fr1()).Project(0.1, 0.1, -1).is_seen);
}

// With k1 = -0.3 the radius r (1 - 0.3 r^2) grows until r = 1 / sqrt(0.9) = 1.054 only.
TEST(Lens, SeesNothingBeyondTheFoldOfThePolynomial) {
  PinholeCamera camera = Fr1();
  camera.distortion = {-0.3, 0, 0, 0, 0};
  EXPECT_TRUE(Lens<double>(camera).Project(1.05, 0, 1).is_seen);
  EXPECT_FALSE(Lens<double>(camera).Project(1.06, 0, 1).is_seen);
}

TEST(Lens, OfAMirroredCameraSeesTheMirroredPointAtTheSamePixel) {
  PinholeCamera camera = Fr1();
  camera.fy = -camera.fy;
  const LensPixel<double> pixel = Lens<double>(camera).Project(0.3, 0.2, 1);
  const LensPixel<double> mirrored = Lens<double>(Mirrored(camera)).Project(0.3, -0.2, 1);
  EXPECT_NEAR(mirrored.u, pixel.u, 1e-12);
  EXPECT_NEAR(mirrored.v, pixel.v, 1e-12);
}

TEST(IsInImage, HoldsUpToHalfAPixelBeyondTheOutermostCentres) {
  const PinholeCamera camera = Fr1();
  EXPECT_TRUE(IsInImage(camera, LensPixel<float>{-0.5f, 479.4f, true}));
  EXPECT_TRUE(IsInImage(camera, LensPixel<float>{639.4f, -0.5f, true}));
  EXPECT_FALSE(IsInImage(camera, LensPixel<float>{-0.6f, 10, true}));
  EXPECT_FALSE(IsInImage(camera, LensPixel<float>{639.5f, 10, true}));
  EXPECT_FALSE(IsInImage(camera, LensPixel<float>{10, 479.5f, true}));
  EXPECT_FALSE(IsInImage(camera, LensPixel<float>{10, 10, false}));
}

}  // namespace
}  // namespace surfit
