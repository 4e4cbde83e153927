// Parts of the robot at the rim of the view.
#include "io/checks/static_parts.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "surfit/io/sequence.h"
#include "testing/matchers.h"
#include "testing/pixels.h"
#include "testing/sequence_writer.h"

namespace surfit::testing {
namespace {

constexpr int kWide = 160, kHigh = 120, kImages = 6;

// Wall whose distance changes by 20 % from image to image, unless the camera stands still.
Image<std::uint16_t> Wall(int image, bool moves = true) {
  Image<std::uint16_t> depth(kWide, kHigh);
  for (const auto [u, v] : PixelsOf(depth))
    depth(u, v) = static_cast<std::uint16_t>(1500 + 2 * u + v + (moves ? 300 * image : 0));
  return depth;
}

// `cover(u, v)`: depth of a part that covers the wall, or 0.
template <typename Cover>
std::vector<FrameImages> Views(const Cover& cover, bool moves = true) {
  std::vector<FrameImages> images(kImages);
  for (int i = 0; i < kImages; ++i) {
    Image<std::uint16_t> depth = Wall(i, moves);
    for (const auto [u, v] : PixelsOf(depth))
      if (cover(u, v) > 0) depth(u, v) = static_cast<std::uint16_t>(cover(u, v));
    images[i].depth = std::move(depth);
  }
  return images;
}

int Bumper(int u, int v) { return v >= 100 ? 500 + u % 7 : 0; }

TEST(StaticParts, AreFoundAtTheRim) {
  const std::optional<StaticParts> parts = FindStaticParts(Views(Bumper));
  ASSERT_TRUE(parts);
  EXPECT_NEAR(parts->ratio, 20. / kHigh, 0.01);
  EXPECT_EQ(parts->mask(80, 110), 1);
  EXPECT_EQ(parts->mask(80, 90), 0);
}

TEST(StaticParts, AreNoneInOrdinaryViewsAndForACameraThatStandsStill) {
  const auto nothing = [](int, int) { return 0; };
  EXPECT_FALSE(FindStaticParts(Views(nothing)));
  EXPECT_FALSE(FindStaticParts(Views(nothing, /*moves=*/false)));
  EXPECT_FALSE(FindStaticParts(Views(Bumper, /*moves=*/false)));
}

TEST(StaticParts, AreNotInTheMiddleOfTheView) {
  EXPECT_FALSE(FindStaticParts(
      Views([](int u, int v) { return u > 40 && u < 90 && v > 40 && v < 80 ? 500 : 0; })));
}

// A robot that drives over a floor sees the floor at the same depth in all frames.
TEST(StaticParts, AreNoFloorThatContinuesIntoTheScene) {
  std::vector<FrameImages> images(kImages);
  for (int i = 0; i < kImages; ++i) {
    Image<std::uint16_t> depth = Wall(i);
    for (const auto [u, v] : PixelsOf(depth)) {
      const double floor_mm = v > 60 ? 40000. / (v - 60) : 60000;
      depth(u, v) = static_cast<std::uint16_t>(std::min<double>(depth(u, v), floor_mm));
    }
    images[i].depth = std::move(depth);
  }
  EXPECT_FALSE(FindStaticParts(images));
}

TEST(StaticParts, NeedFiveImages) {
  std::vector<FrameImages> images = Views(Bumper);
  images.resize(4);
  EXPECT_FALSE(FindStaticParts(images));
}

TEST(StaticParts, AreMissingDepthInEachFrameAndReported) {
  const TempFolder folder;
  const Image<std::uint16_t> bumper = std::get<Image<std::uint16_t>>(Views(Bumper)[0].depth);
  for (int i = 0; i < 90; ++i) {
    Image<std::uint16_t> depth = Wall(i / 15);
    for (const auto [u, v] : PixelsOf(depth))
      if (Bumper(u, v) > 0) depth(u, v) = bumper(u, v);
    WriteDepth(folder / Format("depth/%06d.png", i), depth);
  }
  folder.Write("camera.yaml",
               "depth_camera: { width: 160, height: 120, fx: 130, fy: 130, cx: 80, cy: 60 }\n"
               "depth_units_per_metre: 1000\n");
  const auto source = OpenSequence(Options(folder));
  EXPECT_THAT(source->info().warnings, ::testing::Contains(Names("rim", "robot", 17)));
  const std::vector<ReadResult> frames = ReadAll(source.get());
  ASSERT_EQ(frames.size(), 90u);
  for (const ReadResult& result : frames) {
    ASSERT_TRUE(result.frame) << result.error;
    EXPECT_EQ(result.frame->depth_m(80, 110), 0);
    EXPECT_GT(result.frame->depth_m(80, 50), 1);
  }
}

}  // namespace
}  // namespace surfit::testing
