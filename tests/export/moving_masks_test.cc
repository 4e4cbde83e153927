#include "apps/export/moving_masks.h"

#include <gtest/gtest.h>

#include <cmath>

#include "apps/export/color_lens.h"

namespace surfit::testing {
namespace {

constexpr int kWidth = 160, kHeight = 120;

// A wall at 3 m, with an object at 2 m in the rows [40, 80) and the columns [60, 100).
Image<float> DepthWithObject(float object_m) {
  Image<float> depth_m(kWidth, kHeight, 3);
  for (int v = 40; v < 80; ++v) {
    for (int u = 60; u < 100; ++u) depth_m(u, v) = object_m;
  }
  return depth_m;
}

TEST(MovingMasks, ObjectInFrontOfTheMapIsMarked) {
  const Image<std::uint8_t> in_front =
      PixelsInFront(DepthWithObject(2), Image<float>(kWidth, kHeight, 3));
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      // The opening rounds the corners.
      const bool is_corner = (u == 60 || u == 99) && (v == 40 || v == 79);
      if (is_corner) continue;
      EXPECT_EQ(in_front(u, v) > 0, u >= 60 && u < 100 && v >= 40 && v < 80) << u << ' ' << v;
    }
  }
}

TEST(MovingMasks, ObjectOfTheMapNoiseAndUnknownSurfacesAreNotMarked) {
  const Image<std::uint8_t> nothing(kWidth, kHeight, 0);
  EXPECT_EQ(PixelsInFront(DepthWithObject(2), DepthWithObject(2)), nothing);
  EXPECT_EQ(PixelsInFront(DepthWithObject(2.9f), Image<float>(kWidth, kHeight, 3)), nothing);
  EXPECT_EQ(PixelsInFront(DepthWithObject(0), Image<float>(kWidth, kHeight, 3)), nothing);
  EXPECT_EQ(PixelsInFront(DepthWithObject(2), Image<float>(kWidth, kHeight, 0)), nothing);
  Image<float> noise(kWidth, kHeight, 3);
  for (std::size_t i = 0; i < noise.size(); i += 7) noise[i] = 2;
  EXPECT_EQ(PixelsInFront(noise, Image<float>(kWidth, kHeight, 3)), nothing);
}

// A colour camera of twice the resolution, 0.1 m to the right.
TEST(MovingMasks, MaskIsAtTheObjectInTheColorImage) {
  const PinholeCamera depth_camera = {kWidth, kHeight, 130, 130, 79.5, 59.5, {}};
  const PinholeCamera lens = {2 * kWidth, 2 * kHeight, 260, 260, 159.5, 119.5, {}};
  const Rigid3d color_from_depth(Eigen::Quaterniond::Identity(), {-0.1, 0, 0});
  const Image<float> depth_m = DepthWithObject(2);
  const Image<std::uint8_t> in_front = PixelsInFront(depth_m, Image<float>(kWidth, kHeight, 3));
  const Image<std::uint8_t> mask =
      MaskOfColor(in_front, depth_m, depth_camera, color_from_depth, lens);
  // The parallax at 2 m is 260 * 0.1 / 2 = 13 px, the margin is 3 px. A splat extends by 1 px.
  constexpr int kLeft = 120 - 13, kRight = 199 - 13, kTop = 80, kBottom = 159, kBorder = 5;
  for (int v = 0; v < lens.height; ++v) {
    for (int u = 0; u < lens.width; ++u) {
      const auto is_within = [&](int margin) {
        return u >= kLeft - margin && u <= kRight + margin && v >= kTop - margin &&
               v <= kBottom + margin;
      };
      if (is_within(0)) {
        EXPECT_EQ(mask(u, v), 0);
      }
      if (!is_within(kBorder)) {
        EXPECT_EQ(mask(u, v), 255);
      }
    }
  }
}

// Barrel distortion moves pixels near the corners inwards.
TEST(MovingMasks, UndistortedMaskFollowsTheLens) {
  const PinholeCamera distorted = {kWidth, kHeight, 130, 130, 79.5, 59.5, {-0.2, 0, 0, 0, 0}};
  const PinholeCamera lens = {kWidth, kHeight, 130, 130, 79.5, 59.5, {}};
  const Eigen::Vector2d seen = ProjectByLens(distorted, {0.4, 0.3, 1})->pixel;
  const int u = static_cast<int>(std::lround(seen.x())),
            v = static_cast<int>(std::lround(seen.y()));
  Image<std::uint8_t> mask(kWidth, kHeight, 255);
  for (const int dv : {-2, -1, 0, 1, 2}) {
    for (const int du : {-2, -1, 0, 1, 2}) mask(u + du, v + dv) = 0;
  }
  const Image<std::uint8_t> result = UndistortMask(mask, distorted, lens);
  const Eigen::Vector2d expected = lens.Project({0.4, 0.3, 1});
  ASSERT_GT((expected - seen).norm(), 3);
  EXPECT_EQ(result(std::lround(expected.x()), std::lround(expected.y())), 0);
  EXPECT_EQ(result(u - 2, v - 2), 255);
  EXPECT_EQ(result(80, 60), 255);
}

}  // namespace
}  // namespace surfit::testing
