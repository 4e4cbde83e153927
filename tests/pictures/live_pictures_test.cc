#include <gtest/gtest.h>

#include <algorithm>

#include "output/pictures/pictures.h"

namespace surfit::testing {
namespace {

constexpr Rgb8 kGrassGreen = {10, 200, 30}, kAlarm = {205, 20, 20};
constexpr int kPixels = LivePictures::kWidth * LivePictures::kHeight;
const PinholeCamera kCamera{320, 240, 260, 260, 159.5, 119.5};

// A uniform wall at 2 m that faces the origin.
SurfelMap WallAhead(float radius_m = 0.05f) {
  SurfelMap map;
  Surfel surfel;
  surfel.normal_in_world = {0, 0, -1};
  surfel.color = kGrassGreen;
  surfel.radius_m = radius_m;
  surfel.confidence = 20;
  for (int i = -30; i <= 30; ++i) {
    for (int j = -30; j <= 30; ++j) {
      surfel.position_in_world = {0.04f * i, 0.04f * j, 2};
      map.Append(surfel);
    }
  }
  return map;
}

// Number of pixels with this colour. Expects the size of all live pictures.
int Count(const Image<Rgb8>& picture, Rgb8 color) {
  EXPECT_EQ(picture.width(), LivePictures::kWidth);
  EXPECT_EQ(picture.height(), LivePictures::kHeight);
  return static_cast<int>(std::count(picture.data(), picture.data() + picture.size(), color));
}

TEST(LivePictures, ShowTheFrame) {
  RgbdFrame frame;
  frame.color = Image<Rgb8>(320, 240, kGrassGreen);
  EXPECT_GT(Count(LivePictures({kCamera, {}}).OfFrame(frame), kGrassGreen), 0.95 * kPixels);
}

// An image with aspect ratio 2 fills the width and two thirds of the height.
TEST(LivePictures, KeepProportions) {
  RgbdFrame frame;
  frame.color = Image<Rgb8>(400, 200, kGrassGreen);
  EXPECT_NEAR(Count(LivePictures({kCamera, {}}).OfFrame(frame), kGrassGreen), kPixels * 2 / 3,
              0.02 * kPixels);
}

TEST(LivePictures, ShowDepthWithoutColour) {
  RgbdFrame frame;
  frame.depth_m = Image<float>(320, 240, 1.f);
  EXPECT_GT(Count(LivePictures({kCamera, {}}).OfFrame(frame), {127, 127, 127}), 0.9 * kPixels);
}

TEST(LivePictures, ShowTheModelWithColoursAndNormals) {
  LivePictures pictures({kCamera, {}});
  // 2.4 m of wall at 2 m fill 312 of 320 columns and all rows.
  EXPECT_GT(Count(pictures.OfModel(WallAhead(), {}, ModelColors::kColor), kGrassGreen),
            0.8 * kPixels);
  const Image<Rgb8> normals = pictures.OfModel(WallAhead(), {}, ModelColors::kNormals);
  EXPECT_EQ(Count(normals, kGrassGreen), 0);
  EXPECT_GT(Count(normals, {128, 128, 0}), 0.8 * kPixels);
}

// Discs of 24 mm at a spacing of 40 mm do not cover the pixel between four discs.
TEST(LivePictures, ShowTheModelWithoutHoles) {
  LivePictures pictures({kCamera, {}});
  const int whole = Count(pictures.OfModel(WallAhead(), {}, ModelColors::kColor), kGrassGreen);
  EXPECT_GT(Count(pictures.OfModel(WallAhead(0.024f), {}, ModelColors::kColor), kGrassGreen),
            0.99 * whole);
}

TEST(LivePictures, HaveARedFrameIfLost) {
  LivePictures pictures({kCamera, {}});
  EXPECT_EQ(Count(pictures.OfModel(WallAhead(), {}, ModelColors::kColor), kAlarm), 0);
  const Image<Rgb8> lost = pictures.OfLost(Image<Rgb8>(320, 240, {1, 2, 3}));
  EXPECT_GT(Count(lost, kAlarm), 0.1 * kPixels);
  EXPECT_GT(Count(lost, {1, 2, 3}), 0.7 * kPixels);
  EXPECT_GT(Count(pictures.OfLost({}), kAlarm), 0.1 * kPixels);
}

}  // namespace
}  // namespace surfit::testing
