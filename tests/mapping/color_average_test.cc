#include "mapping/fusion/color_average.h"

#include <gtest/gtest.h>

#include "mapping/same_map.h"
#include "surfit/core/parallel.h"
#include "testing/pixels.h"

namespace surfit::testing {
namespace {

constexpr Rgb8 kColorBefore = {1, 2, 3};

// Map of a wall at 2 m, and of a post at 1 m in front of its right half. The camera is at the
// origin.
class ColorAverages : public ::testing::Test {
 protected:
  ColorAverages() {
    for (int i = -40; i <= 40; ++i) {
      for (int j = -30; j <= 30; ++j) Append({0.02f * i, 0.02f * j, 2});
    }
    for (int i = 0; i <= 10; ++i) {
      for (int j = -30; j <= 30; ++j) Append({0.01f * i, 0.01f * j, 1});
    }
  }

  void Append(const Eigen::Vector3f& at) {
    Surfel surfel;
    surfel.position_in_world = at;
    surfel.normal_in_world = {0, 0, -1};
    surfel.radius_m = 0.02f;
    surfel.confidence = 20;
    surfel.color = kColorBefore;
    map_.Append(surfel);
  }

  // Adds the colours of frames at this position, one per set of pixels (2 x 2). Columns from
  // `end_of_depth` have no depth.
  void Add(const Image<Rgb8>& color, const Eigen::Vector3d& at, ColorAverage* average,
           int end_of_depth = 480) const {
    RgbdFrame frame;
    frame.color = color;
    const Rigid3d pose(Eigen::Quaterniond::Identity(), at);
    const PosedCamera camera(camera_, pose);
    const BlendedView drawn = DrawBlended(map_, {camera_, {}}, pose);
    Image<float> measured_m = drawn.depth_m;
    for (const auto [u, v] : PixelsOf(measured_m)) {
      if (u >= end_of_depth) measured_m(u, v) = 0;
    }
    for (int i = 0; i < 4; ++i) {
      average->Add(FrameColors(frame, camera, {}), {camera_, {}}, pose, {{measured_m, camera}});
    }
  }

  const PinholeCamera camera_ = {480, 360, 480, 480, 239.5, 179.5, {}};
  SurfelMap map_;
};

// Without measured depth, another depth image can show a surface.
TEST_F(ColorAverages, UseAllImagesOfDepth) {
  const Image<float> none(480, 360, 0.f);
  const PosedCamera camera(camera_, Rigid3d());
  const Image<float> stereo_m = DrawBlended(map_, {camera_, {}}, Rigid3d()).depth_m;
  RgbdFrame frame;
  frame.color = Image<Rgb8>(480, 360, {200, 100, 50});
  const auto colored = [&](const std::vector<DepthPicture>& shown) {
    SurfelMap map = map_;
    ColorAverage average(map);
    average.Add(FrameColors(frame, camera, {}), {camera_, {}}, Rigid3d(), shown);
    average.WriteTo(&map);
    int count = 0;
    for (const std::int32_t id : map.Ids()) count += map.Color(id) == kColorBefore ? 0 : 1;
    return count;
  };
  EXPECT_EQ(colored({{none, camera}}), 0);
  EXPECT_GT(colored({{none, camera}, {stereo_m, camera}}), 1000);
  EXPECT_EQ(colored({{none, camera}, {stereo_m, camera}}), colored({{stereo_m, camera}}));
}

TEST_F(ColorAverages, AreMeansOfFrameColors) {
  ColorAverage average(map_);
  Add(Image<Rgb8>(480, 360, {200, 100, 50}), {0, 0, 0}, &average);
  Add(Image<Rgb8>(480, 360, {100, 150, 70}), {0, 0, 0}, &average);
  Add(Image<Rgb8>(480, 360, {60, 80, 90}), {0, 0, 0}, &average);
  average.WriteTo(&map_);
  int seen = 0;
  for (const std::int32_t id : map_.Ids()) {
    const Surfel surfel = map_[id];
    if (surfel.color == kColorBefore) continue;
    EXPECT_NEAR(surfel.color.r, 120, 1);
    EXPECT_NEAR(surfel.color.g, 110, 1);
    EXPECT_NEAR(surfel.color.b, 70, 1);
    ++seen;
  }
  EXPECT_GT(seen, 4000);
}

// The wall is at 2 m and at 1.5 m, and the post occludes none of these surfels. The number of
// pixels per surfel has the ratio (2 / 1.5)^2.
TEST_F(ColorAverages, WeighFramesByTheirPixelsPerSurfel) {
  ColorAverage average(map_);
  Add(Image<Rgb8>(480, 360, {200, 100, 50}), {0, 0, 0}, &average);
  Add(Image<Rgb8>(480, 360, {100, 150, 250}), {0, 0, 0.5}, &average);
  average.WriteTo(&map_);
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  int count = 0;
  for (const std::int32_t id : map_.Ids()) {
    const Surfel surfel = map_[id];
    const Eigen::Vector3f p = surfel.position_in_world;
    if (p.z() < 1.5f || p.x() > -0.2f || p.x() < -0.5f || std::abs(p.y()) > 0.3f) continue;
    sum += Eigen::Vector3f(surfel.color.r, surfel.color.g, surfel.color.b);
    ++count;
  }
  const double ratio = 16. / 9;
  EXPECT_NEAR(sum.x() / count, (200 + ratio * 100) / (1 + ratio), 1);
  EXPECT_NEAR(sum.y() / count, (100 + ratio * 150) / (1 + ratio), 1);
  EXPECT_NEAR(sum.z() / count, (50 + ratio * 250) / (1 + ratio), 2);
}

// The blending weight is about exp(-2 d^2 / R^2), with R = 2 cm. Drawing and averaging blur a wave
// of 30 cm with this kernel, which leaves 0.957 of the amplitude.
TEST_F(ColorAverages, RecoverColorsOfRenderedViews) {
  const auto wave = [](const Eigen::Vector3f& p) {
    return 128.f + 100.f * std::sin(2 * static_cast<float>(M_PI) / 0.3f * p.x());
  };
  SurfelMap colored = map_;
  for (const std::int32_t id : colored.Ids()) {
    SurfelBlock& block = colored.block(id / SurfelBlock::kCapacity);
    const int k = id % SurfelBlock::kCapacity;
    block.SetColor(k, Eigen::Vector3f::Constant(wave(block.Position(k))), 1);
  }
  ColorAverage average(map_);
  for (const double right_m : {0., 0.1, -0.1}) {
    const Rigid3d pose(Eigen::Quaterniond::Identity(), {right_m, 0, 0});
    Add(DrawBlended(colored, {camera_, {}}, pose).color, pose.translation, &average);
  }
  average.WriteTo(&map_);
  int count = 0;
  for (const std::int32_t id : map_.Ids()) {
    const Surfel surfel = map_[id];
    const Eigen::Vector3f p = surfel.position_in_world;
    if (p.z() < 1.5f || p.x() > -0.199f || p.x() < -0.601f || std::abs(p.y()) > 0.401f) continue;
    ASSERT_NEAR(surfel.color.r, wave(p), 0.043 * 100 + 5) << p.transpose();
    ++count;
  }
  EXPECT_GT(count, 800);
}

// The post occludes the wall between 0 and 20 cm to the right of the middle. A pixel is 4 mm on
// the wall.
TEST_F(ColorAverages, IgnoreOccludedSurfels) {
  ColorAverage average(map_);
  Add(Image<Rgb8>(480, 360, {200, 100, 50}), {0, 0, 0}, &average);
  average.WriteTo(&map_);
  for (const std::int32_t id : map_.Ids()) {
    const Surfel surfel = map_[id];
    const Eigen::Vector3f p = surfel.position_in_world;
    if (std::abs(p.y()) > 0.2f) continue;
    const bool is_hidden = p.z() > 1.5f && p.x() > -0.01f && p.x() < 0.21f;
    const bool is_clear = p.z() < 1.5f || p.x() < -0.1f || p.x() > 0.3f;
    if (!is_hidden && !is_clear) continue;
    EXPECT_EQ(surfel.color == kColorBefore, is_hidden) << p.transpose();
  }
}

// A surface without depth can occlude the wall, so its colours are not used. Depth ends at x =
// -0.5 m on the wall, and a splat has a radius of 4 cm.
TEST_F(ColorAverages, IgnoreColorsWithoutDepth) {
  ColorAverage average(map_);
  Add(Image<Rgb8>(480, 360, {200, 100, 50}), {0, 0, 0}, &average, 120);
  average.WriteTo(&map_);
  int colored = 0;
  for (const std::int32_t id : map_.Ids()) {
    const Surfel surfel = map_[id];
    const Eigen::Vector3f p = surfel.position_in_world;
    if (p.z() < 1.5f || std::abs(p.y()) > 0.5f) continue;
    const bool is_colored = surfel.color != kColorBefore;
    EXPECT_FALSE(is_colored && p.x() > -0.46f) << p.transpose();
    colored += is_colored;
  }
  EXPECT_GT(colored, 200);
}

TEST_F(ColorAverages, AreTheSameAtAnyNumberOfThreads) {
  Image<Rgb8> color(480, 360);
  for (const auto [u, v] : PixelsOf(color)) {
    color(u, v) = {static_cast<std::uint8_t>(1 + u / 2), static_cast<std::uint8_t>(1 + v / 2), 90};
  }
  std::vector<SurfelMap> maps(2, map_);
  for (int i = 0; i < 2; ++i) {
    const ThreadLimit limit(1 + 3 * i);
    ColorAverage average(maps[i]);
    for (const double right_m : {0., 0.1, -0.1}) Add(color, {right_m, 0, 0}, &average);
    average.WriteTo(&maps[i]);
  }
  ExpectSameMap(maps[0], maps[1]);
}

}  // namespace
}  // namespace surfit::testing
