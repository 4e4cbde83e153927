#include <gmock/gmock.h>

#include <algorithm>

#include "output/pictures/pictures.h"
#include "pictures/picture_file.h"
#include "testing/matchers.h"
#include "testing/pixels.h"
#include "testing/temp_folder.h"

namespace surfit::testing {
namespace {

constexpr Rgb8 kEstimateColor = {230, 90, 0}, kGroundTruthColor = {20, 90, 210};

// A path of 2 m along x, then half of that along z, in a world whose y is down.
Trajectory Corner(double shift_m) {
  Trajectory path;
  for (int i = 0; i <= 30; ++i) {
    StampedPose pose;
    pose.world_from_camera.translation = {std::min(0.1 * i, 2.), 0, std::max(0.1 * i - 2, 0.)};
    pose.world_from_camera.translation.z() += shift_m;
    path.push_back(pose);
  }
  return path;
}

struct Extent {
  int left = 1 << 30, right = -1, top = 1 << 30, bottom = -1;
};

// Of the pixels of that colour in the left view, whose box is (90, 110) to (790, 820).
Extent FindExtent(const Image<Rgb8>& picture, Rgb8 color) {
  Extent extent;
  for (const auto [u, v] : Pixels(90, 790, 110, 820)) {
    if (picture(u, v) != color) continue;
    extent.left = std::min(extent.left, u), extent.right = std::max(extent.right, u);
    extent.top = std::min(extent.top, v), extent.bottom = std::max(extent.bottom, v);
  }
  return extent;
}

TEST(WriteTrajectoryPicture, ShowsBothPathsInTheirColors) {
  const TempFolder folder;
  WriteTrajectoryPicture(Corner(0), Corner(0.3), folder / "trajectory.png");
  const Image<Rgb8> picture = ReadPicture(folder / "trajectory.png");
  EXPECT_EQ(picture.width(), 1600);
  EXPECT_EQ(picture.height(), 900);
  EXPECT_GT(CountPixels(picture, kEstimateColor), 500u);
  EXPECT_GT(CountPixels(picture, kGroundTruthColor), 500u);
}

TEST(WriteTrajectoryPicture, BothAxesHaveTheSameScaleAndZGrowsUpwards) {
  const TempFolder folder;
  WriteTrajectoryPicture(Corner(0), {}, folder / "trajectory.png");
  const Image<Rgb8> picture = ReadPicture(folder / "trajectory.png");
  EXPECT_EQ(CountPixels(picture, kGroundTruthColor), 0u);
  const Extent path = FindExtent(picture, kEstimateColor);
  // 2 m fill 90 % of 700 pixels: 315 pixels a metre, and up to 8 more on each side for the marks.
  EXPECT_NEAR(path.right - path.left, 630, 16);
  EXPECT_NEAR(path.bottom - path.top, 315, 16);
  EXPECT_EQ(picture(path.left + 40, path.bottom - 40).r, 255);  // the corner is at the lower right
}

TEST(WriteTrajectoryPicture, TakesPathsOfNoPoseAndOfOne) {
  const TempFolder folder;
  EXPECT_NO_THROW(WriteTrajectoryPicture({}, {}, folder / "empty.png"));
  EXPECT_NO_THROW(WriteTrajectoryPicture(Trajectory(1), {}, folder / "one.png"));
  EXPECT_GT(CountPixels(ReadPicture(folder / "one.png"), kEstimateColor), 50u);
}

TEST(WriteTrajectoryPicture, NamesTheFileItCannotWrite) {
  ExpectInputError([] { WriteTrajectoryPicture(Corner(0), {}, "/nonexistent/t.png"); },
                   HasSubstr("/nonexistent/t.png"));
}

}  // namespace
}  // namespace surfit::testing
