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

  // Adds the colours of a frame at `right_m` metres to the right. Columns from `end_of_depth` have
  // no depth.
  void Add(const Image<Rgb8>& color, float right_m, ColorAverage* average,
           int end_of_depth = 160) const {
    RgbdFrame frame;
    frame.color = color;
    const Rigid3d pose(Eigen::Quaterniond::Identity(), {right_m, 0, 0});
    const PosedCamera camera(camera_, pose);
    const BlendedView drawn = DrawBlended(map_, {camera_, {}}, pose);
    Image<float> measured_m = drawn.depth_m;
    for (const auto [u, v] : PixelsOf(measured_m)) {
      if (u >= end_of_depth) measured_m(u, v) = 0;
    }
    average->Add(FrameColors(frame, camera, {}), camera, {drawn.depth_m, camera},
                 {measured_m, camera});
  }

  const PinholeCamera camera_ = {160, 120, 160, 160, 79.5, 59.5, {}};
  SurfelMap map_;
};

TEST_F(ColorAverages, AreMeansOfFrameColors) {
  ColorAverage average(map_);
  Add(Image<Rgb8>(160, 120, {200, 100, 50}), 0, &average);
  Add(Image<Rgb8>(160, 120, {100, 150, 70}), 0, &average);
  Add(Image<Rgb8>(160, 120, {60, 80, 90}), 0, &average);
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

// The post occludes the wall between 0 and 20 cm to the right of the middle. A pixel is 12.5 mm on
// the wall.
TEST_F(ColorAverages, IgnoreOccludedSurfels) {
  ColorAverage average(map_);
  Add(Image<Rgb8>(160, 120, {200, 100, 50}), 0, &average);
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

// A surface without depth can occlude the wall, so its colours are not used. A pixel is 12.5 mm on
// the wall.
TEST_F(ColorAverages, IgnoreColorsWithoutDepth) {
  ColorAverage average(map_);
  Add(Image<Rgb8>(160, 120, {200, 100, 50}), 0, &average, 40);
  average.WriteTo(&map_);
  int colored = 0;
  for (const std::int32_t id : map_.Ids()) {
    const Surfel surfel = map_[id];
    const Eigen::Vector3f p = surfel.position_in_world;
    if (p.z() < 1.5f || std::abs(p.y()) > 0.5f) continue;
    const bool is_colored = surfel.color != kColorBefore;
    EXPECT_FALSE(is_colored && p.x() > -0.49f) << p.transpose();
    colored += is_colored;
  }
  EXPECT_GT(colored, 200);
}

TEST_F(ColorAverages, AreTheSameAtAnyNumberOfThreads) {
  Image<Rgb8> color(160, 120);
  for (const auto [u, v] : PixelsOf(color)) {
    color(u, v) = {static_cast<std::uint8_t>(1 + u), static_cast<std::uint8_t>(1 + v), 90};
  }
  std::vector<SurfelMap> maps(2, map_);
  for (int i = 0; i < 2; ++i) {
    const ThreadLimit limit(1 + 3 * i);
    ColorAverage average(maps[i]);
    for (const float right_m : {0.f, 0.1f, -0.1f}) Add(color, right_m, &average);
    average.WriteTo(&maps[i]);
  }
  ExpectSameMap(maps[0], maps[1]);
}

}  // namespace
}  // namespace surfit::testing
