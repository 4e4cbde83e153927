#include "finishing/stereo/unmeasured_surfaces.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

#include "mapping/same_map.h"
#include "surfit/core/parallel.h"
#include "testing/pixels.h"

namespace surfit::testing {
namespace {

constexpr double kWall_m = 2, kPicture_m = 1.75;
constexpr double kHalfWidth_m = 0.3, kHalfHeight_m = 0.2;

// Random grey value of a square.
double Noise(int i, int j) {
  auto hash = static_cast<std::uint32_t>(i * 73856093) ^ static_cast<std::uint32_t>(j * 19349663);
  hash = (hash ^ hash >> 15) * 2246822519u;
  hash = (hash ^ hash >> 13) * 3266489917u;
  return (hash >> 16 & 255u) / 255.0;
}

// Smooth random texture with squares of 3 cm.
std::uint8_t Texture(double x, double y) {
  const double a = x / 0.03, b = y / 0.03;
  const int i = static_cast<int>(std::floor(a)), j = static_cast<int>(std::floor(b));
  const double s = a - i, t = b - j;
  const double value = (1 - s) * (1 - t) * Noise(i, j) + s * (1 - t) * Noise(i + 1, j) +
                       (1 - s) * t * Noise(i, j + 1) + s * t * Noise(i + 1, j + 1);
  return static_cast<std::uint8_t>(40 + 180 * value);
}

// Keyframes of a textured picture in front of a textured wall. The camera moves to the right. The
// depth of the picture is missing.
class UnmeasuredSurfacesTest : public ::testing::Test {
 protected:
  UnmeasuredSurfacesTest() {
    for (int i = 0; i < 9; ++i) keyframes_.push_back(KeyframeAt(0.1 * (i - 4), i));
  }

  static StereoKeyframe KeyframeAt(double x, int index) {
    StereoKeyframe keyframe;
    keyframe.index = index;
    keyframe.camera = {160, 120, 150, 150, 79.5, 59.5, {}};
    keyframe.world_from_camera = Rigid3d(Eigen::Quaterniond::Identity(), {x, 0, 0});
    keyframe.color = Image<Rgb8>(160, 120);
    keyframe.measured_m = Image<float>(160, 120, 0.f);
    for (const auto [u, v] : PixelsOf(keyframe.camera)) {
      const Eigen::Vector3d ray = keyframe.camera.Ray(u, v);
      const bool is_picture = IsPicture(x + kPicture_m * ray.x(), kPicture_m * ray.y());
      const double z = is_picture ? kPicture_m : kWall_m;
      const std::uint8_t grey = Texture(x + z * ray.x() + (is_picture ? 10 : 0), z * ray.y());
      keyframe.color(u, v) = {grey, grey, grey};
      if (!is_picture) keyframe.measured_m(u, v) = kWall_m;
    }
    return keyframe;
  }

  static bool IsPicture(double x, double y) {
    return std::abs(x) < kHalfWidth_m && std::abs(y) < kHalfHeight_m;
  }

  std::optional<UnmeasuredSurfaces> Find(bool interrupted = false) const {
    return FindUnmeasuredSurfaces(keyframes_, map_, {keyframes_.front().camera, {}}, {},
                                  interrupted);
  }

  std::vector<StereoKeyframe> keyframes_;
  SurfelMap map_;
};

using UnmeasuredSurfacesThreads = UnmeasuredSurfacesTest;

TEST_F(UnmeasuredSurfacesTest, ReturnASurfaceWithoutDepth) {
  const std::optional<UnmeasuredSurfaces> found = Find();
  ASSERT_TRUE(found);
  ASSERT_EQ(found->depth_m.size(), 9u);
  int near = 0;
  for (const Surfel& surfel : found->surfels) {
    EXPECT_TRUE(surfel.from_stereo);
    if (std::abs(surfel.position_in_world.z() - kPicture_m) < 0.02) ++near;
  }
  EXPECT_GT(near, 0.95 * static_cast<double>(found->surfels.size()));
  int pixels = 0, filled = 0;
  for (const auto [u, v] : PixelsOf(found->depth_m[4])) {
    const float depth_m = found->depth_m[4](u, v);
    if (keyframes_[4].measured_m(u, v) > 0) {
      EXPECT_EQ(depth_m, 0);
      continue;
    }
    ++pixels;
    filled += std::abs(depth_m - kPicture_m) < 0.02 ? 1 : 0;
  }
  EXPECT_GT(filled, 0.8 * pixels);
}

TEST_F(UnmeasuredSurfacesTest, LeaveOutSurfacesOfTheMap) {
  const std::optional<UnmeasuredSurfaces> without_map = Find();
  ASSERT_TRUE(without_map);
  for (const auto [i, j] : Pixels(-40, 41, -30, 31)) {
    Surfel surfel;
    surfel.position_in_world = {0.01f * static_cast<float>(i), 0.01f * static_cast<float>(j),
                                kPicture_m};
    if (!IsPicture(surfel.position_in_world.x(), surfel.position_in_world.y())) continue;
    surfel.normal_in_world = {0, 0, -1};
    surfel.radius_m = 0.01f;
    surfel.confidence = 20;
    map_.Append(surfel);
  }
  const std::optional<UnmeasuredSurfaces> found = Find();
  ASSERT_TRUE(found);
  EXPECT_LT(found->surfels.size(), 0.02 * static_cast<double>(without_map->surfels.size()));
  EXPECT_FLOAT_EQ(found->depth_m[4](80, 60), kPicture_m);
}

// As of a picture that was taken away.
TEST_F(UnmeasuredSurfacesTest, DoNotContradictMeasuredDepth) {
  for (int i = 0; i < 9; ++i) {
    StereoKeyframe keyframe = KeyframeAt(0.1 * (i - 4), 9 + i);
    for (float& depth_m : keyframe.measured_m) depth_m = kWall_m;
    keyframes_.push_back(keyframe);
  }
  const std::optional<UnmeasuredSurfaces> found = Find();
  ASSERT_TRUE(found);
  for (const Surfel& surfel : found->surfels) EXPECT_GT(surfel.position_in_world.z(), 1.85f);
}

TEST_F(UnmeasuredSurfacesTest, AreEmptyWithoutMeasuredDepth) {
  for (StereoKeyframe& keyframe : keyframes_) {
    for (float& depth_m : keyframe.measured_m) depth_m = 0;
  }
  const std::optional<UnmeasuredSurfaces> found = Find();
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->surfels.empty() && found->depth_m.empty());
}

TEST_F(UnmeasuredSurfacesTest, CanBeInterrupted) { EXPECT_FALSE(Find(true)); }

TEST_F(UnmeasuredSurfacesThreads, AreTheSameAtAnyNumberOfThreads) {
  const auto found = [&](int threads) {
    const ThreadLimit limit(threads);
    return Find();
  };
  const std::optional<UnmeasuredSurfaces> one = found(1), four = found(4);
  ASSERT_TRUE(one && four);
  ASSERT_EQ(one->surfels.size(), four->surfels.size());
  for (std::size_t i = 0; i < one->surfels.size(); ++i) {
    EXPECT_EQ(AsTuple(one->surfels[i]), AsTuple(four->surfels[i]));
  }
  EXPECT_EQ(one->depth_m, four->depth_m);
}

}  // namespace
}  // namespace surfit::testing
