#include "surfit/frame/preprocess.h"

#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "frame/plane_images.h"
#include "surfit/core/options.h"
#include "surfit/core/parallel.h"
#include "testing/expect_input_error.h"

namespace surfit {
namespace {

void ExpectSame(const VectorImage& a, const VectorImage& b) {
  EXPECT_TRUE(a.x == b.x && a.y == b.y && a.z == b.z);
}

PinholeCamera QuarterCamera() {
  PinholeCamera camera = testing::SmallCamera();
  camera.width = 320;
  camera.height = 240;
  camera.cx = 160.4;
  camera.cy = 118.7;
  camera.fx = camera.fy = 260;
  return camera;
}

Image<float> NoisyDepth(const PinholeCamera& camera) {
  Image<float> depth_m = PlaneDepth(testing::TiltedPlane(0.5, 1), camera);
  std::mt19937_64 rng(2);
  std::uniform_real_distribution<float> noise(0.99f, 1.01f);
  std::uniform_int_distribution<int> dice(0, 20);
  for (float& z : depth_m) z = dice(rng) == 0 ? 0.f : z * noise(rng);
  return depth_m;
}

TEST(PreprocessDepth, IsItsPartsInOrder) {
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
  const auto preprocess = [&](int threads) {
    const ThreadLimit limit(threads);
    return PreprocessDepth(depth_m, {camera, {}}, PreprocessOptions());
  };
  const FramePyramid expected = preprocess(1);
  for (const int threads : {2, 4}) {
    const FramePyramid pyramid = preprocess(threads);
    ASSERT_EQ(pyramid.levels.size(), expected.levels.size());
    for (std::size_t i = 0; i < expected.levels.size(); ++i) {
      ExpectSame(pyramid.levels[i].vertex, expected.levels[i].vertex);
      ExpectSame(pyramid.levels[i].normal, expected.levels[i].normal);
    }
  }
}

TEST(PreprocessDepth, AnImageWithoutDepthHasNoSurface) {
  const PinholeCamera camera = testing::SmallCamera();
  const Image<float> missing(camera.width, camera.height, 0.f);
  for (const FrameLevel& level :
       PreprocessDepth(missing, {camera, {}}, PreprocessOptions()).levels) {
    const VectorImage zero(level.camera.width, level.camera.height);
    ExpectSame(level.vertex, zero);
    ExpectSame(level.normal, zero);
  }
}

TEST(PreprocessOptions, ValidateNamesFieldValueAndConstraint) {
  Validate(PreprocessOptions());
  const auto expect = [](const std::function<void(PreprocessOptions*)>& change,
                         const char* message) {
    PreprocessOptions options;
    change(&options);
    testing::ExpectInputError([&] { Validate(options); }, ::testing::StrEq(message));
  };
  expect([](auto* o) { o->filter_radius_px = 8; }, "filter_radius_px is 8, must be from 0 to 7");
  expect([](auto* o) { o->filter_radius_px = -1; }, "filter_radius_px is -1, must be from 0 to 7");
  expect([](auto* o) { o->filter_cutoff = 0; },
         "filter_cutoff is 0, must be positive and below 1000");
  expect([](auto* o) { o->normal_radius_px = 0; }, "normal_radius_px is 0, must be from 1 to 7");
  expect([](auto* o) { o->max_slant_rad = 1.6; },
         "max_slant_rad is 1.6, must be positive and below 1.57");
  expect([](auto* o) { o->pyramid_levels = 0; }, "pyramid_levels is 0, must be from 1 to 8");
}

}  // namespace
}  // namespace surfit
