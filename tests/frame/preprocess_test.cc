#include "surfit/frame/preprocess.h"

#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <random>

#include "frame/lens.h"
#include "frame/plane_images.h"
#include "surfit/core/options.h"
#include "surfit/geometry/sensor.h"
#include "testing/matchers.h"
#include "testing/threads.h"

namespace surfit::testing {
namespace {

void ExpectSame(const VectorImage& a, const VectorImage& b) {
  EXPECT_TRUE(a.x == b.x && a.y == b.y && a.z == b.z);
}

PinholeCamera QuarterCamera() {
  PinholeCamera camera = {320, 240, 260, 260, 160.4, 118.7, {}};
  return camera;
}

Image<float> NoisyDepth(const PinholeCamera& camera) {
  Image<float> depth_m = PlaneDepth(TiltedPlane(0.5, 1), camera);
  std::mt19937_64 rng(2);
  std::uniform_real_distribution<float> noise(0.99f, 1.01f);
  std::uniform_int_distribution<int> dice(0, 20);
  for (float& z : depth_m) z = dice(rng) == 0 ? 0.f : z * noise(rng);
  return depth_m;
}

TEST(PreprocessDepth, RunsFilterNormalsAndPyramid) {
  const PinholeCamera camera = QuarterCamera();
  const Image<float> depth_m = NoisyDepth(camera);
  const PreprocessOptions options;
  const FramePyramid pyramid = PreprocessDepth(depth_m, {camera, {}}, options);
  const VectorImage vertex = VertexMap(FilterDepth(depth_m, DepthNoise(), options), camera);
  ExpectSame(pyramid.levels[0].vertex, vertex);
  ExpectSame(pyramid.levels[0].normal, NormalMap(vertex, {camera, {}}, options));
  ASSERT_EQ(pyramid.levels.size(), 4u);
  for (int i = 1; i < 4; ++i) {
    const FrameLevel level = HalfResolution(pyramid.levels[i - 1], options);
    ExpectSame(pyramid.levels[i].vertex, level.vertex);
    ExpectSame(pyramid.levels[i].normal, level.normal);
  }
}

TEST(PreprocessDepth, IsTheSameAtAnyNumberOfThreads) {
  const PinholeCamera camera = QuarterCamera();
  const Image<float> depth_m = NoisyDepth(camera);
  const auto pyramids = AtThreads({1, 2, 4}, [&] {
    return PreprocessDepth(depth_m, {camera, {}}, PreprocessOptions());
  });
  const FramePyramid& expected = pyramids[0];
  for (const FramePyramid& pyramid : pyramids) {
    ASSERT_EQ(pyramid.levels.size(), expected.levels.size());
    for (std::size_t i = 0; i < expected.levels.size(); ++i) {
      ExpectSame(pyramid.levels[i].vertex, expected.levels[i].vertex);
      ExpectSame(pyramid.levels[i].normal, expected.levels[i].normal);
    }
  }
}

TEST(PreprocessDepth, AnImageWithoutDepthHasNoSurface) {
  const PinholeCamera camera = SmallCamera();
  const Image<float> missing(camera.width, camera.height, 0.f);
  for (const FrameLevel& level :
       PreprocessDepth(missing, {camera, {}}, PreprocessOptions()).levels) {
    const VectorImage zero(level.camera.width, level.camera.height);
    ExpectSame(level.vertex, zero);
    ExpectSame(level.normal, zero);
  }
}

TEST(PreprocessOptions, RejectsInvalidFieldsByName) {
  Validate(PreprocessOptions());
  const auto expect = [](const std::function<void(PreprocessOptions*)>& change,
                         const auto&... names) {
    PreprocessOptions options;
    change(&options);
    ExpectInputError([&] { Validate(options); }, testing::Names(names...));
  };
  expect([](auto* o) { o->filter_radius_px = 8; }, "filter_radius_px", 8, 0, 7);
  expect([](auto* o) { o->filter_radius_px = -1; }, "filter_radius_px", -1, 0, 7);
  expect([](auto* o) { o->filter_cutoff = 0; }, "filter_cutoff", 0, 1000);
  expect([](auto* o) { o->normal_radius_px = 0; }, "normal_radius_px", 0, 1, 7);
  expect([](auto* o) { o->max_slant_rad = 1.6; }, "max_slant_rad", 1.6, 1.57);
  expect([](auto* o) { o->pyramid_levels = 0; }, "pyramid_levels", 0, 1, 8);
}

PinholeCamera Fr1() {
  return {640, 480, 517.3, 516.5, 318.6, 255.3, {.2624, -.9531, -.0054, .0026, 1.1633}};
}

// Displacement by one coefficient at a time, in the order of OpenCV (k1 k2 p1 p2 k3), at x = 0.5, y
// = 0.25, r2 = 0.3125. The formula is from the camera calibration page of OpenCV.
TEST(Lens, CoefficientsAgreeWithOpenCv) {
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

TEST(Lens, WithoutDistortionAgreesWithProject) {
  PinholeCamera camera = Fr1();
  camera.distortion = {};
  const Eigen::Vector3d point(0.3, -0.2, 1.7);
  const LensPixel<double> pixel = Lens<double>(camera).Project(point);
  EXPECT_LT((Eigen::Vector2d(pixel.u, pixel.v) - camera.Project(point)).norm(), 1e-12);
}

TEST(Lens, PointsBehindCameraAreNotSeen) {
  EXPECT_FALSE(Lens<double>(Fr1()).Project(0.1, 0.1, 0).is_seen);
  EXPECT_FALSE(Lens<double>(Fr1()).Project(0.1, 0.1, -1).is_seen);
}

// With k1 = -0.3, the radius r (1 - 0.3 r^2) increases only up to r = 1 / sqrt(0.9) = 1.054.
TEST(Lens, PointsBeyondMaximumOfDistortionAreNotSeen) {
  PinholeCamera camera = Fr1();
  camera.distortion = {-0.3, 0, 0, 0, 0};
  EXPECT_TRUE(Lens<double>(camera).Project(1.05, 0, 1).is_seen);
  EXPECT_FALSE(Lens<double>(camera).Project(1.06, 0, 1).is_seen);
}

TEST(Lens, MirroredCameraProjectsMirroredPointToSamePixel) {
  PinholeCamera camera = Fr1();
  camera.fy = -camera.fy;
  const LensPixel<double> pixel = Lens<double>(camera).Project(0.3, 0.2, 1);
  const LensPixel<double> mirrored = Lens<double>(Mirrored(camera)).Project(0.3, -0.2, 1);
  EXPECT_NEAR(mirrored.u, pixel.u, 1e-12);
  EXPECT_NEAR(mirrored.v, pixel.v, 1e-12);
}

TEST(IsInImage, IncludesHalfPixelAroundOuterPixelCentres) {
  const PinholeCamera camera = Fr1();
  EXPECT_TRUE(IsInImage(camera, LensPixel<float>{-0.5f, 479.4f, true}));
  EXPECT_TRUE(IsInImage(camera, LensPixel<float>{639.4f, -0.5f, true}));
  EXPECT_FALSE(IsInImage(camera, LensPixel<float>{-0.6f, 10, true}));
  EXPECT_FALSE(IsInImage(camera, LensPixel<float>{639.5f, 10, true}));
  EXPECT_FALSE(IsInImage(camera, LensPixel<float>{10, 479.5f, true}));
  EXPECT_FALSE(IsInImage(camera, LensPixel<float>{10, 10, false}));
}

}  // namespace
}  // namespace surfit::testing
