#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "frame/plane_images.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/frame/preprocess.h"
#include "testing/matchers.h"
#include "testing/pixels.h"

namespace surfit::testing {
namespace {

FrameLevel LevelOf(const Image<float>& depth_m, const PinholeCamera& camera) {
  FrameLevel level;
  level.camera = camera;
  level.vertex = VertexMap(depth_m, camera);
  level.normal = NormalMap(level.vertex, {camera, {}}, PreprocessOptions());
  return level;
}

// 4 x 2 image of two blocks. All normals are (0, 0, -1).
FrameLevel TwoBlocks(const std::array<float, 8>& depth_m) {
  PinholeCamera camera = SmallCamera();
  camera.width = 4;
  camera.height = 2;
  Image<float> image(4, 2);
  std::copy(depth_m.begin(), depth_m.end(), image.begin());
  FrameLevel level = LevelOf(image, camera);
  for (const auto [u, v] : PixelsOf(4, 2))
    level.normal.Set(u, v, {0, 0, image(u, v) > 0 ? -1.f : 0.f});
  return level;
}

// Roundings of four values, of their mean, and of 1 / z twice.
constexpr double kMeanTolerance = 8 * kFloatRounding;

TEST(HalfResolution, IsMeanInverseDepthOfEachBlock) {
  const FrameLevel fine = TwoBlocks({1.f, 1.01f, 2.f, 2.02f,  //
                                     1.02f, 1.03f, 2.04f, 2.06f});
  const FrameLevel coarse = HalfResolution(fine, PreprocessOptions());
  ASSERT_EQ(coarse.vertex.width(), 2);
  ASSERT_EQ(coarse.vertex.height(), 1);
  const double first = 4 / (1 / 1. + 1 / 1.01 + 1 / 1.02 + 1 / 1.03);
  const double second = 4 / (1 / 2. + 1 / 2.02 + 1 / 2.04 + 1 / 2.06);
  EXPECT_NEAR(coarse.vertex.z(0, 0), first, kMeanTolerance * first);
  EXPECT_NEAR(coarse.vertex.z(1, 0), second, kMeanTolerance * second);
}

TEST(HalfResolution, IgnoresMissingPixels) {
  const FrameLevel coarse =
      HalfResolution(TwoBlocks({1.f, 0.f, 0.f, 0.f, 0.f, 1.02f, 0.f, 0.f}), PreprocessOptions());
  const double mean = 2 / (1 + 1 / 1.02);
  EXPECT_NEAR(coarse.vertex.z(0, 0), mean, kMeanTolerance * mean);
  EXPECT_THAT(coarse.normal(0, 0), VectorNear(Eigen::Vector3f(0, 0, -1), 0.f));
  EXPECT_TRUE(coarse.vertex(1, 0).isZero(0.f));
  EXPECT_TRUE(coarse.normal(1, 0).isZero(0.f));
}

TEST(HalfResolution, KeepsTheNearSideOfADepthEdge) {
  FrameLevel fine = TwoBlocks({1.f, 3.f, 2.f, 5.f, 3.f, 3.f, 5.f, 2.02f});
  fine.normal.Set(0, 0, {0.6f, 0, -0.8f});
  fine.normal.Set(2, 0, {0.6f, 0, -0.8f});
  const FrameLevel coarse = HalfResolution(fine, PreprocessOptions());
  EXPECT_NEAR(coarse.vertex.z(0, 0), 1, kMeanTolerance);
  EXPECT_THAT(coarse.normal(0, 0), VectorNear(Eigen::Vector3f(0.6f, 0, -0.8f), 1e-6f));
  const double mean = 2 / (1 / 2. + 1 / 2.02);
  EXPECT_NEAR(coarse.vertex.z(1, 0), mean, kMeanTolerance * mean);
  const Eigen::Vector3f normal = Eigen::Vector3f(0.6f, 0, -1.8f).normalized();
  EXPECT_THAT(coarse.normal(1, 0), VectorNear(normal, 1e-6f));
}

// Rough surface with holes and with steps near the threshold of a depth edge. Unit normals have
// random directions, and some are missing.
FrameLevel RoughLevel(int width, int height) {
  FrameLevel level;
  level.camera = SmallCamera();
  level.camera.width = width;
  level.camera.height = height;
  std::mt19937_64 rng(7);
  std::normal_distribution<float> noise(0, 1);
  std::uniform_int_distribution<int> dice(0, 5);
  std::uniform_real_distribution<float> step(0, 0.2f);
  Image<float> depth_m(width, height);
  level.normal = VectorImage(width, height);
  for (const auto [u, v] : PixelsOf(width, height)) {
    const float inverse = 0.6f + 0.002f * noise(rng) + (dice(rng) < 3 ? step(rng) : 0.f);
    depth_m(u, v) = dice(rng) < 2 ? 0.f : 1.f / inverse;
    const Eigen::Vector3f n(noise(rng), noise(rng), noise(rng));
    if (dice(rng) > 0) level.normal.Set(u, v, n.normalized());
  }
  level.vertex = VertexMap(depth_m, level.camera);
  return level;
}

struct BlockMean {
  double depth_m = 0;
  Eigen::Vector3d normal_sum = Eigen::Vector3d::Zero();
  bool close = false;  // too close to the edge threshold for single precision
};

// Mean of a block by definition, in double precision.
BlockMean MeanOfBlock(const FrameLevel& fine, int u, int v, const PreprocessOptions& options) {
  double nearest = 0;
  std::vector<std::pair<double, Eigen::Vector3d>> pixels;
  for (int i = 0; i < 4; ++i) {
    const int x = 2 * u + i % 2, y = 2 * v + i / 2;
    if (fine.vertex.z(x, y) == 0) continue;
    pixels.emplace_back(1.0 / fine.vertex.z(x, y), fine.normal(x, y).cast<double>());
    nearest = std::max(nearest, pixels.back().first);
  }
  const double edge = 3 * DepthNoise().inverse_depth_sigma +
                      nearest * std::tan(options.max_slant_rad) / fine.camera.fx;
  double sum = 0;
  int count = 0;
  BlockMean mean;
  for (const auto& [inverse, normal] : pixels) {
    mean.close |= std::abs(nearest - inverse - edge) < 1e-5;
    if (inverse < nearest - edge) continue;
    sum += inverse;
    mean.normal_sum += normal;
    ++count;
  }
  if (count > 0) mean.depth_m = count / sum;
  return mean;
}

TEST(HalfResolution, AgreesWithDefinitionInDoublePrecisionAtAnyWidth) {
  const PreprocessOptions options;
  for (const int width : {2, 3, 15, 16, 17, 18, 31, 35, 80}) {
    const FrameLevel fine = RoughLevel(width, 23);
    const FrameLevel coarse = HalfResolution(fine, options);
    ASSERT_EQ(coarse.vertex.width(), width / 2);
    ASSERT_EQ(coarse.vertex.height(), 11);
    for (const auto [u, v] : PixelsOf(width / 2, 11)) {
      const BlockMean mean = MeanOfBlock(fine, u, v, options);
      if (mean.close) continue;
      ASSERT_NEAR(coarse.vertex.z(u, v), mean.depth_m, kMeanTolerance * mean.depth_m);
      const double norm = mean.normal_sum.norm();
      const Eigen::Vector3d normal = norm > 0 ? mean.normal_sum / norm : mean.normal_sum;
      // Three roundings of sums of up to four unit vectors. The relative error is larger if the
      // vectors almost cancel.
      ASSERT_THAT(coarse.normal(u, v).cast<double>(),
                  VectorNear(normal, 4 * kMeanTolerance * (1 + 1 / std::max(norm, 1e-3))));
    }
  }
}

// A plane is linear in inverse depth. The mean of a block is the value at its centre, which is the
// pixel of the binned camera: planes are exact on every level.
TEST(BuildPyramid, KeepsPlanesExactOnEveryLevel) {
  PinholeCamera camera = {336, 240, 240, 235, 165.2, 121.9, {}};
  const Plane plane = TiltedPlane(0.6, 2.5);
  const FramePyramid pyramid =
      BuildPyramid(LevelOf(PlaneDepth(plane, camera), camera), PreprocessOptions());
  ASSERT_EQ(pyramid.levels.size(), 4u);
  for (std::size_t i = 0; i < pyramid.levels.size(); ++i) {
    const FrameLevel& level = pyramid.levels[i];
    const PinholeCamera expected = camera.Binned(1 << i);
    EXPECT_EQ(level.camera.width, expected.width);
    EXPECT_EQ(level.camera.height, expected.height);
    EXPECT_NEAR(level.camera.fx, expected.fx, 1e-9);
    EXPECT_NEAR(level.camera.fy, expected.fy, 1e-9);
    EXPECT_NEAR(level.camera.cx, expected.cx, 1e-9);
    EXPECT_NEAR(level.camera.cy, expected.cy, 1e-9);
    ASSERT_EQ(level.vertex.width(), expected.width);
    ASSERT_EQ(level.normal.height(), expected.height);
    for (const auto [u, v] : Pixels(1, expected.width - 1, 1, expected.height - 1)) {
      const Eigen::Vector3d x = level.vertex(u, v).cast<double>();
      const double z = 1 / plane.InverseDepth(expected.Ray(u, v));
      const double tolerance = kMeanTolerance * static_cast<double>(i + 1);
      ASSERT_THAT(x, VectorNear(z * expected.Ray(u, v), tolerance * x.norm()));
      // Mean of normals of the finest level (normal_map_test.cc).
      const double normal_tolerance = 6 * camera.fx * 2 * kFloatRounding * kLongestRay;
      ASSERT_THAT(level.normal(u, v).cast<double>(), VectorNear(plane.normal, normal_tolerance));
    }
  }
}

struct SizeCase {
  int width, height, most_levels, levels;
};

class PyramidSizes : public ::testing::TestWithParam<SizeCase> {};

TEST_P(PyramidSizes, HasFewerLevelsForSmallImages) {
  PinholeCamera camera = SmallCamera();
  camera.width = GetParam().width;
  camera.height = GetParam().height;
  PreprocessOptions options;
  options.pyramid_levels = GetParam().most_levels;
  const FramePyramid pyramid =
      PreprocessDepth(Image<float>(camera.width, camera.height, 1.f), {camera, {}}, options);
  ASSERT_EQ(pyramid.levels.size(), static_cast<std::size_t>(GetParam().levels));
  for (std::size_t i = 0; i < pyramid.levels.size(); ++i) {
    EXPECT_EQ(pyramid.levels[i].camera.width, camera.width >> i);
    EXPECT_EQ(pyramid.levels[i].vertex.width(), camera.width >> i);
    EXPECT_EQ(pyramid.levels[i].normal.height(), camera.height >> i);
  }
}

INSTANTIATE_TEST_SUITE_P(All, PyramidSizes,
                         ::testing::Values(SizeCase{640, 480, 4, 4}, SizeCase{640, 480, 8, 5},
                                           SizeCase{640, 480, 1, 1},
                                           SizeCase{40, 30, 4, 1},  // --downsample=16
                                           SizeCase{80, 60, 4, 2}, SizeCase{79, 60, 4, 1},
                                           SizeCase{80, 59, 4, 1}, SizeCase{321, 243, 4, 4},
                                           SizeCase{7, 5, 4, 1}),
                         [](const auto& instance) {
                           const SizeCase& size = instance.param;
                           return std::to_string(size.width) + "x" + std::to_string(size.height) +
                                  "_" + std::to_string(size.most_levels);
                         });

FramePyramid TwoLevels() {
  PinholeCamera camera = SmallCamera();
  camera.width = 80;
  camera.height = 60;
  return PreprocessDepth(Image<float>(80, 60, 1.f), {camera, {}}, PreprocessOptions());
}

TEST(GreyOf, IncreasesFromBlackToWhite) {
  EXPECT_EQ(GreyOf({0, 0, 0}), 0.f);
  EXPECT_NEAR(GreyOf({255, 255, 255}), 1.f, 1e-6);
  EXPECT_GT(GreyOf({0, 255, 0}), GreyOf({255, 0, 0}));
  EXPECT_GT(GreyOf({255, 0, 0}), GreyOf({0, 0, 255}));
}

TEST(AddIntensity, SetsMeansOfFinerLevel) {
  FramePyramid pyramid = TwoLevels();
  ASSERT_EQ(pyramid.levels.size(), 2u);
  Image<Rgb8> color(80, 60, {10, 10, 10});
  color(2, 4) = {90, 90, 90};
  AddIntensity(color, &pyramid);
  ASSERT_EQ(pyramid.levels[1].intensity.width(), 40);
  ASSERT_EQ(pyramid.levels[1].intensity.height(), 30);
  EXPECT_NEAR(pyramid.levels[0].intensity(2, 4), 90 / 255., 1e-6);
  EXPECT_NEAR(pyramid.levels[1].intensity(1, 2), 30 / 255., 1e-6);
  EXPECT_NEAR(pyramid.levels[1].intensity(0, 2), 10 / 255., 1e-6);
}

TEST(AddIntensity, IsNanWithoutColor) {
  FramePyramid pyramid = TwoLevels();
  Image<Rgb8> color(80, 60, {10, 10, 10});
  color(2, 4) = {};
  AddIntensity(color, &pyramid);
  EXPECT_TRUE(std::isnan(pyramid.levels[0].intensity(2, 4)));
  EXPECT_TRUE(std::isnan(pyramid.levels[1].intensity(1, 2)));
  EXPECT_FALSE(std::isnan(pyramid.levels[1].intensity(2, 2)));
}

TEST(AddIntensity, KeepsLevelsIfColorIsEmpty) {
  FramePyramid pyramid = TwoLevels();
  AddIntensity({}, &pyramid);
  EXPECT_TRUE(pyramid.levels[0].intensity.empty());
}

}  // namespace
}  // namespace surfit::testing
