#include "mapping/rendering/frame_colors.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "mapping/plane_frame.h"
#include "testing/matchers.h"
#include "testing/pixels.h"

namespace surfit::testing {
namespace {

PinholeCamera ColorCamera() { return {120, 90, 100, 100, 59.5, 44.5, {}}; }
const Eigen::Vector3f kTowards = {0, 0, -1};

// The red value is twice the column, and the green value is twice the row. So a colour determines a
// position to half a pixel.
RgbdFrame PlaceFrame() {
  RgbdFrame frame = BlankFrame(ColorCamera(), 0).frame;
  for (const auto [u, v] : PixelsOf(frame.color)) {
    frame.color(u, v) = {static_cast<std::uint8_t>(2 * u), static_cast<std::uint8_t>(2 * v), 9};
  }
  return frame;
}

SeenColor ColorAt(const RgbdFrame& frame, const FrameMotion& motion, const Eigen::Vector3f& point,
                  const Eigen::Vector3f& normal = kTowards) {
  return FrameColors(frame, PosedCamera(ColorCamera(), {}), motion).At(point, normal);
}

TEST(FrameColors, AreBilinear) {
  const SeenColor seen = ColorAt(PlaceFrame(), {}, {0.103f, -0.057f, 1});
  EXPECT_NEAR(seen.color.x(), 2 * (59.5 + 10.3), 1e-3);
  EXPECT_NEAR(seen.color.y(), 2 * (44.5 - 5.7), 1e-3);
  EXPECT_NEAR(seen.color.z(), 9, 1e-4);
}

// Pixel of a point at the capture time of its row, found by a search over all rows.
TEST(FrameColors, UseCaptureTimeOfRow) {
  RgbdFrame frame = PlaceFrame();
  frame.stamp_s = 5;
  frame.color_stamp_s = 5.012;
  const FrameMotion motion = {{{0.5, -0.9, 0.3}, {0.3, -0.2, 0.1}}, 1. / 30};
  for (const Eigen::Vector3d& point :
       {Eigen::Vector3d(0.3, 0.3, 1), Eigen::Vector3d(-0.5, -0.4, 1.5), Eigen::Vector3d(0, 0, 2)}) {
    Eigen::Vector2d place;
    double least = 1e9;
    for (double row = 0; row < 90; row += 0.01) {
      const double t = 0.012 + ((row + 0.5) / 90 - 0.5) / 30;
      const Eigen::Vector3d way =
          motion.camera.angular_velocity_rad_per_s.cross(point) + motion.camera.velocity_m_per_s;
      const Eigen::Vector2d seen = ColorCamera().Project(point - t * way);
      if (std::abs(seen.y() - row) >= least) continue;
      least = std::abs(seen.y() - row);
      place = seen;
    }
    ASSERT_LT(least, 0.02);
    const SeenColor seen = ColorAt(frame, motion, point.cast<float>());
    // The rates are assumed constant: at 1 rad/s for 30 ms, the error of a path of 3 px is about 3
    // %.
    EXPECT_NEAR(seen.color.x() / 2, place.x(), 0.1);
    EXPECT_NEAR(seen.color.y() / 2, place.y(), 0.1);
    EXPECT_GT((ColorCamera().Project(point) - place).norm(), 0.2);
  }
}

TEST(FrameColors, WeightDecreasesWithPixelSizeSlantAndBlur) {
  const RgbdFrame frame = PlaceFrame();
  const auto weight = [&](const FrameMotion& motion, float z, const Eigen::Vector3f& normal) {
    return ColorAt(frame, motion, {0, 0, z}, normal).weight;
  };
  EXPECT_NEAR(weight({}, 0.2f, kTowards), 1, 1e-5);  // 500 px/m
  EXPECT_NEAR(weight({}, 0.4f, kTowards), 0.25, 1e-5);
  EXPECT_NEAR(weight({}, 0.2f, {0, 0.8f, -0.6f}), 0.6, 1e-5);
  // 1 m/s at 0.2 m is 500 px/s: 2.5 px in 5 ms.
  EXPECT_NEAR(weight({{{0, 0, 0}, {1, 0, 0}}, 0}, 0.2f, kTowards), 1 / std::pow(7.25, 2), 1e-4);
}

TEST(FrameColors, HaveZeroWeightOutsideImage) {
  EXPECT_EQ(ColorAt(PlaceFrame(), {}, {0.7f, 0, 1}).weight, 0);
  EXPECT_EQ(ColorAt(PlaceFrame(), {}, {0, -0.5f, 1}).weight, 0);
  EXPECT_GT(ColorAt(PlaceFrame(), {}, {0.595f, 0.445f, 1}).weight,
            0);  // the centre of the last pixel
}

// Black borders of 8 px on the left and 5 px at the bottom, and a black screen in the middle.
TEST(FrameColors, IgnoreBlackBordersButNotBlackObjects) {
  RgbdFrame frame = PlaceFrame();
  for (const auto [u, v] : PixelsOf(frame.color)) {
    const bool is_screen = std::abs(u - 60) < 15 && std::abs(v - 45) < 15;
    if (u < 8 || v >= 85 || is_screen) frame.color(u, v) = {};
  }
  const auto seen_at = [&](float u, float v) {
    return ColorAt(frame, {}, {(u - 59.5f) / 100, (v - 44.5f) / 100, 1});
  };
  for (const float u : {1.f, 6.f, 7.6f}) EXPECT_EQ(seen_at(u, 40).weight, 0) << u;
  for (const float v : {84.4f, 86.f}) EXPECT_EQ(seen_at(40, v).weight, 0) << v;
  EXPECT_GT(seen_at(8.1f, 40).weight, 0);
  EXPECT_NEAR(seen_at(8.1f, 40).color.x(), 16.2, 0.01);
  EXPECT_GT(seen_at(60, 45).weight, 0);
  EXPECT_EQ(seen_at(60, 45).color, Eigen::Vector3f(0, 0, 0));
}

// Some points are outside the image. The count is not a multiple of the batch size.
TEST(FrameColors, BatchAgreesWithSinglePoints) {
  RgbdFrame frame = PlaceFrame();
  frame.color_stamp_s = frame.stamp_s + 0.01;
  for (const auto [u, v] : PixelsOf(frame.color)) {
    if (u < 8 || (u % 7 == 3 && v % 5 == 2)) frame.color(u, v) = {};
  }
  const FrameMotion motion = {{{0.5, -0.9, 0.3}, {0.3, -0.2, 0.1}}, 1. / 30};
  const FrameColors colors(frame, PosedCamera(ColorCamera(), {}), motion);
  const Eigen::Vector3f normal(0.1f, -0.2f, -0.97f);
  ColorBatch batch;
  for (int k = 0; k < 59; ++k) {
    const auto step = static_cast<float>(k);
    batch.Add({0.025f * step - 0.75f, 0.3f - 0.01f * step, 1 + 0.01f * step}, normal);
  }
  colors.LookUp(&batch);
  int seen = 0;
  for (int k = 0; k < batch.count; ++k) {
    const auto& p = batch.patch;
    const SeenColor alone = colors.At({p[0][k], p[1][k], p[2][k]}, normal);
    EXPECT_EQ(batch.Seen(k).color, alone.color) << k;
    EXPECT_EQ(batch.Seen(k).weight, alone.weight) << k;
    if (alone.weight > 0) ++seen;
  }
  EXPECT_GT(seen, 20);
  EXPECT_LT(seen, 55);
}

TEST(Fusion, IgnoresBlackBorders) {
  FrameWithSurface first = WallFrame(TestCamera(), {}, 2, 0), second = first;
  second.frame.index = 1;
  for (const auto [u, v] : PixelsOf(first.frame.color)) {
    if (u < 10) first.frame.color(u, v) = {};
    if (u >= 50) second.frame.color(u, v) = {};
  }
  Fusion fusion({});
  SurfelMap map;
  Fuse(first, {}, &fusion, &map);
  int unseen = 0;
  for (const std::int32_t id : map.Ids()) {
    if (map[id].color_weight > 0) continue;
    EXPECT_EQ(map.Color(id), Rgb8());  // black until a colour is observed
    ++unseen;
  }
  EXPECT_GT(unseen, 0);
  Fuse(second, {}, &fusion, &map);
  for (const std::int32_t id : map.Ids()) EXPECT_EQ(map.Color(id), (Rgb8{100, 150, 200}));
}

}  // namespace
}  // namespace surfit::testing
