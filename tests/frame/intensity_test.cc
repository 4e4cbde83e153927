#include <gtest/gtest.h>

#include <cmath>

#include "frame/plane_images.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/frame/preprocess.h"

namespace surfit {
namespace {

FramePyramid TwoLevels() {
  PinholeCamera camera = testing::SmallCamera();
  camera.width = 80;
  camera.height = 60;
  return PreprocessDepth(Image<float>(80, 60, 1.f), {camera, {}}, PreprocessOptions());
}

TEST(GreyOf, IsFromBlackToWhite) {
  EXPECT_EQ(GreyOf({0, 0, 0}), 0.f);
  EXPECT_NEAR(GreyOf({255, 255, 255}), 1.f, 1e-6);
  EXPECT_GT(GreyOf({0, 255, 0}), GreyOf({255, 0, 0}));
  EXPECT_GT(GreyOf({255, 0, 0}), GreyOf({0, 0, 255}));
}

TEST(AddIntensity, GivesEachLevelTheMeansOfTheFinerOne) {
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

TEST(AddIntensity, KeepsUnknownWhatHasNoColor) {
  FramePyramid pyramid = TwoLevels();
  Image<Rgb8> color(80, 60, {10, 10, 10});
  color(2, 4) = {};
  AddIntensity(color, &pyramid);
  EXPECT_TRUE(std::isnan(pyramid.levels[0].intensity(2, 4)));
  EXPECT_TRUE(std::isnan(pyramid.levels[1].intensity(1, 2)));
  EXPECT_FALSE(std::isnan(pyramid.levels[1].intensity(2, 2)));
}

TEST(AddIntensity, LeavesLevelsWithoutColorAsTheyAre) {
  FramePyramid pyramid = TwoLevels();
  AddIntensity({}, &pyramid);
  EXPECT_TRUE(pyramid.levels[0].intensity.empty());
}

}  // namespace
}  // namespace surfit
