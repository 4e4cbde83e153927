#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "output/pictures/pictures.h"
#include "pictures/picture_file.h"
#include "testing/matchers.h"
#include "testing/pixels.h"
#include "testing/temp_folder.h"

namespace surfit::testing {
namespace {

constexpr Rgb8 kEstimateColor = {230, 90, 0}, kGroundTruthColor = {145, 190, 250};

// A path of 2 m along x and 1 m along z, in a world frame with y down.
Trajectory Corner(double shift_m) {
  Trajectory path;
  for (int i = 0; i <= 30; ++i) {
    StampedPose pose;
    pose.stamp_s = 0.1 * i;
    pose.world_from_camera.translation = {std::min(0.1 * i, 2.), 0, std::max(0.1 * i - 2, 0.)};
    pose.world_from_camera.translation.z() += shift_m;
    path.push_back(pose);
  }
  return path;
}

struct Extent {
  int left = 1 << 30, right = -1, top = 1 << 30, bottom = -1;
};

const Pixels kLeftView(90, 790, 110, 820);

// Extent of the pixels with this colour in the region.
Extent FindExtent(const Image<Rgb8>& picture, Rgb8 color, const Pixels& among) {
  Extent extent;
  for (const auto [u, v] : among) {
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
  EXPECT_EQ(picture.height(), 1320);
  EXPECT_GT(CountPixels(picture, kEstimateColor), 500u);
  EXPECT_GT(CountPixels(picture, kGroundTruthColor), 500u);
}

TEST(WriteTrajectoryPicture, ShowsBothPathsIfTheyCoincide) {
  const TempFolder folder;
  WriteTrajectoryPicture(Corner(0), Corner(0), folder / "trajectory.png");
  const Image<Rgb8> picture = ReadPicture(folder / "trajectory.png");
  const Extent estimate = FindExtent(picture, kEstimateColor, kLeftView);
  const Extent truth = FindExtent(picture, kGroundTruthColor, kLeftView);
  // The ground truth is drawn as a wider line below the estimate.
  EXPECT_LT(truth.left, estimate.left);
  EXPECT_GT(truth.right, estimate.right);
  EXPECT_LT(truth.top, estimate.top);
  EXPECT_GT(truth.bottom, estimate.bottom);
  int estimate_rows = 0, truth_rows = 0;  // rows of the line along x, 1 m after its start
  for (int v = estimate.bottom - 30; v <= estimate.bottom + 10; ++v) {
    estimate_rows += picture(440, v) == kEstimateColor;
    truth_rows += picture(440, v) == kGroundTruthColor;
  }
  EXPECT_GE(estimate_rows, 2);
  EXPECT_GE(truth_rows, 4);
}

TEST(WriteTrajectoryPicture, ShowsTheErrorOverTime) {
  const TempFolder folder;
  Trajectory estimate = Corner(0.01);  // 10 mm for 1.5 s, then 20 mm until 3 s
  for (std::size_t i = 16; i < estimate.size(); ++i) {
    estimate[i].world_from_camera.translation.y() += std::sqrt(3) * 0.01;
  }
  estimate[5].stamp_s += 0.04;  // no ground-truth pose within 10 ms: not in the panel
  estimate[5].world_from_camera.translation.y() += 1;
  WriteTrajectoryPicture(estimate, Corner(0), folder / "trajectory.png");
  const Image<Rgb8> picture = ReadPicture(folder / "trajectory.png");
  const Extent early = FindExtent(picture, kEstimateColor, {90, 820, 950, 1250});
  const Extent late = FindExtent(picture, kEstimateColor, {900, 1580, 950, 1250});
  EXPECT_LE(early.left, 92);
  EXPECT_GE(late.right, 1577);
  // The axis ranges from 0 at the lower edge to 10 % above the largest error.
  EXPECT_NEAR(1250 - (early.top + early.bottom) / 2., 300 / 1.1 / 2, 1);
  EXPECT_NEAR(1250 - (late.top + late.bottom) / 2., 300 / 1.1, 1);
  EXPECT_LE(early.bottom - early.top, 3);
  EXPECT_LE(late.bottom - late.top, 3);
}

TEST(WriteTrajectoryPicture, HasNoErrorPanelWithoutTruePoses) {
  const TempFolder folder;
  Trajectory elsewhere = Corner(0);
  for (StampedPose& pose : elsewhere) pose.stamp_s += 100;
  for (const Trajectory& truth : {Trajectory(), elsewhere}) {
    WriteTrajectoryPicture(Corner(0), truth, folder / "trajectory.png");
    EXPECT_EQ(ReadPicture(folder / "trajectory.png").height(), 900);
  }
}

TEST(WriteTrajectoryPicture, BothAxesHaveTheSameScaleAndZGrowsUpwards) {
  const TempFolder folder;
  WriteTrajectoryPicture(Corner(0), {}, folder / "trajectory.png");
  const Image<Rgb8> picture = ReadPicture(folder / "trajectory.png");
  EXPECT_EQ(CountPixels(picture, kGroundTruthColor), 0u);
  const Extent path = FindExtent(picture, kEstimateColor, kLeftView);
  // 2 m fill 90 % of 700 pixels: 315 pixels per metre, plus up to 8 pixels per side for markers.
  EXPECT_NEAR(path.right - path.left, 630, 16);
  EXPECT_NEAR(path.bottom - path.top, 315, 16);
  EXPECT_EQ(picture(path.left + 40, path.bottom - 40).r,
            255);  // the corner of the path is at the lower right
}

TEST(WriteTrajectoryPicture, AcceptsPathsWithZeroAndOnePose) {
  const TempFolder folder;
  EXPECT_NO_THROW(WriteTrajectoryPicture({}, {}, folder / "empty.png"));
  EXPECT_NO_THROW(WriteTrajectoryPicture(Trajectory(1), {}, folder / "one.png"));
  EXPECT_GT(CountPixels(ReadPicture(folder / "one.png"), kEstimateColor), 50u);
}

TEST(WriteTrajectoryPicture, RejectsUnwritableFile) {
  ExpectInputError([] { WriteTrajectoryPicture(Corner(0), {}, "/nonexistent/t.png"); },
                   Names("/nonexistent/t.png"));
}

}  // namespace
}  // namespace surfit::testing
