#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "pictures/picture_view.h"
#include "surfit/pictures/pictures.h"

namespace surfit::testing {
namespace {

constexpr Rgb8 kGrassGreen = {10, 200, 30};
const PinholeCamera kCamera{320, 240, 260, 260, 159.5, 119.5};

// A wall of one colour, 2 m before the origin and facing it.
SurfelMap WallAhead() {
  SurfelMap map;
  Surfel surfel;
  surfel.normal_in_world = {0, 0, -1};
  surfel.color = kGrassGreen;
  surfel.radius_m = 0.05f;
  surfel.confidence = 20;
  for (int i = -30; i <= 30; ++i) {
    for (int j = -30; j <= 30; ++j) {
      surfel.position_in_world = {0.04f * i, 0.04f * j, 2};
      map.Append(surfel);
    }
  }
  return map;
}

// How many pixels of the rows [begin, end) have the colour.
int Count(const Image<Rgb8>& image, Rgb8 color, int begin, int end) {
  int count = 0;
  for (int v = begin; v < end; ++v) {
    count += static_cast<int>(std::count(image.row(v), image.row(v) + image.width(), color));
  }
  return count;
}

constexpr int kTile = LivePicture::kTileWidth * LivePicture::kTileHeight;

TEST(LivePicture, ShowsTheFrameInItsTile) {
  LivePicture picture({kCamera, {}});
  RgbdFrame frame;
  frame.color = Image<Rgb8>(320, 240, kGrassGreen);
  picture.ShowFrame(frame);
  EXPECT_GT(Count(picture.image(), kGrassGreen, 0, LivePicture::kTileHeight), 0.95 * kTile);
  EXPECT_EQ(Count(picture.image(), kGrassGreen, LivePicture::kTileHeight, LivePicture::kHeight), 0);
}

TEST(LivePicture, ShowsDepthWhereThereIsNoColour) {
  LivePicture picture({kCamera, {}});
  RgbdFrame frame;
  frame.depth_m = Image<float>(320, 240, 1.f);
  picture.ShowFrame(frame);
  EXPECT_GT(Count(picture.image(), {127, 127, 127}, 0, LivePicture::kTileHeight), 0.9 * kTile);
}

TEST(LivePicture, ShowsTheModelByColourAndByNormal) {
  LivePicture picture({kCamera, {}});
  // 2.4 m of wall at 2 m fill 312 of 320 columns and all rows.
  picture.ShowModel(WallAhead(), {}, ModelColors::kColor);
  EXPECT_GT(Count(picture.image(), kGrassGreen, 0, LivePicture::kTileHeight), 0.8 * kTile);
  picture.ShowModel(WallAhead(), {}, ModelColors::kNormals);
  EXPECT_EQ(Count(picture.image(), kGrassGreen, 0, LivePicture::kTileHeight), 0);
  EXPECT_GT(Count(picture.image(), {128, 128, 0}, 0, LivePicture::kTileHeight), 0.8 * kTile);
}

TEST(LivePicture, ShowsTheMapAndThePathBeforeIt) {
  constexpr int kTop = LivePicture::kTileHeight + LivePicture::kTextHeight;
  LivePicture picture({kCamera, {}});
  picture.ShowMap(WallAhead(), {});
  const int without_path = Count(picture.image(), kGrassGreen, kTop, LivePicture::kHeight);
  EXPECT_GT(without_path, 10000);
  constexpr Rgb8 kPath = {255, 150, 30};
  EXPECT_EQ(Count(picture.image(), kPath, kTop, LivePicture::kHeight), 0);
  Trajectory path(2);
  path[1].world_from_camera.translation = {0.5, 0, 1};
  picture.ShowMap(WallAhead(), path);
  EXPECT_GT(Count(picture.image(), kPath, kTop, LivePicture::kHeight), 50);
}

TEST(LivePicture, LeavesAnEmptyMapOut) {
  LivePicture picture({kCamera, {}});
  const Image<Rgb8> before = picture.image();
  picture.ShowMap(SurfelMap(), {});
  EXPECT_EQ(picture.image(), before);
}

int CountInMap(const LivePicture& picture, Rgb8 color) {
  constexpr int kTop = LivePicture::kTileHeight + LivePicture::kTextHeight;
  return Count(picture.image(), color, kTop, LivePicture::kHeight);
}

TEST(LivePicture, ShowsLoopsInTheMap) {
  constexpr Rgb8 kLoop = {60, 220, 120};
  LivePicture picture({kCamera, {}});
  picture.ShowMap(WallAhead(), Trajectory(1));
  EXPECT_EQ(CountInMap(picture, kLoop), 0);
  picture.ShowMap(WallAhead(), Trajectory(1), {{{-1, 0, 0.5}, {1, 0, 0.5}}});
  EXPECT_GT(CountInMap(picture, kLoop), 50);
}

// From behind the wall shows nothing: its surfels face the other way.
TEST(LivePicture, TurnsTheMap) {
  LivePicture picture({kCamera, {}});
  picture.SetOrbit({EIGEN_PI, 0, 1, {0, 0, 0}, false});
  picture.ShowMap(WallAhead(), {});
  EXPECT_EQ(CountInMap(picture, kGrassGreen), 0);
  picture.SetOrbit({2 * EIGEN_PI, 0, 1, {0, 0, 0}, false});
  picture.ShowMap(WallAhead(), {});
  EXPECT_GT(CountInMap(picture, kGrassGreen), 10000);
}

// At twice the distance a quarter of the pixels, but for perspective and borders.
TEST(LivePicture, ZoomsAndDragsTheMap) {
  LivePicture picture({kCamera, {}});
  picture.ShowMap(WallAhead(), {});
  const int near = CountInMap(picture, kGrassGreen);
  picture.SetOrbit({0, 0, 2, {0, 0, 0}, false});
  picture.ShowMap(WallAhead(), {});
  const int far = CountInMap(picture, kGrassGreen);
  EXPECT_NEAR(far, near / 4., 0.1 * near);
  picture.DragMap(LivePicture::kWidth, 0);  // out of the picture
  picture.ShowMap(WallAhead(), {});
  EXPECT_LT(CountInMap(picture, kGrassGreen), 0.1 * far);
}

TEST(LivePicture, FollowsTheCamera) {
  Trajectory path(2);
  path[1].world_from_camera.translation = {40, 0, 0};  // far from the wall
  LivePicture picture({kCamera, {}});
  picture.SetOrbit({0, 0, 0.02, {0, 0, 0}, true});
  picture.ShowMap(WallAhead(), path);
  EXPECT_EQ(CountInMap(picture, kGrassGreen), 0);
  EXPECT_GT(CountInMap(picture, {255, 40, 40}), 20);  // the camera is in the middle
}

TEST(LivePicture, DrawsTheMapCoarselyWhereItIsToBeQuick) {
  LivePicture picture({kCamera, {}});
  picture.ShowMap(WallAhead(), {});
  const int fine = CountInMap(picture, kGrassGreen);
  picture.ShowMap(WallAhead(), {}, {}, /*coarsely=*/true);
  EXPECT_NEAR(CountInMap(picture, kGrassGreen), fine, 0.1 * fine);  // but for its borders
}

TEST(LivePicture, TellsInRedThatItIsLost) {
  constexpr Rgb8 kAlarm = {205, 20, 20};
  LivePicture picture({kCamera, {}});
  picture.ShowModel(WallAhead(), {}, ModelColors::kColor);
  EXPECT_EQ(Count(picture.image(), kAlarm, 0, LivePicture::kTileHeight), 0);
  picture.ShowLost(Image<Rgb8>(320, 240, {1, 2, 3}));
  EXPECT_GT(Count(picture.image(), kAlarm, 0, LivePicture::kTileHeight), 0.1 * kTile);
  EXPECT_GT(Count(picture.image(), {1, 2, 3}, 0, LivePicture::kTileHeight), 0.7 * kTile);
  picture.ShowLost({});
  EXPECT_GT(Count(picture.image(), kAlarm, 0, LivePicture::kTileHeight), 0.1 * kTile);
}

TEST(LiveMapView, HoldsThePointsAndThePath) {
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 100; ++i) points.emplace_back(0.1f * (i % 10), 0.1f * (i / 10), 3.f);
  Trajectory path(2);
  path[1].world_from_camera.translation = {-4, 0, 1};
  const PictureView view = Overview(points, path, 300, 200).view;
  for (const StampedPose& pose : path) {
    points.push_back(pose.world_from_camera.translation.cast<float>());
  }
  for (const Eigen::Vector3f& point : points) {
    const Eigen::Vector3d p = view.camera_from_world * point.cast<double>();
    ASSERT_GT(p.z(), 0);
    const Eigen::Vector2d pixel = view.camera.Project(p);
    EXPECT_TRUE(pixel.x() > 0 && pixel.x() < 300 && pixel.y() > 0 && pixel.y() < 200) << pixel;
  }
}

}  // namespace
}  // namespace surfit::testing
