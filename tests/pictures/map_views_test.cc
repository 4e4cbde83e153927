#include "output/pictures/map_views.h"

#include <gtest/gtest.h>

#include "output/pictures/picture_view.h"
#include "output/pictures/splat_renderer.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

constexpr int kViewWidth = 160, kViewHeight = 120;
// What a surfel of the test's room belongs to, kept as its first_seen.
enum Part { kFloor, kCeiling, kFrontWall, kRightWall };

void AppendPlane(Part part, const Eigen::Vector3f& corner, const Eigen::Vector3f& a,
                 const Eigen::Vector3f& b, const Rigid3d& world_from_room, SurfelMap* map) {
  constexpr int kSteps = 40;
  Surfel surfel;
  surfel.first_seen = part;
  surfel.radius_m = 0.15f;
  surfel.confidence = 10;
  const Rigid3f pose = world_from_room.cast<float>();
  surfel.normal_in_world = pose.rotation * a.cross(b).normalized();
  for (int i = 0; i <= kSteps; ++i) {
    for (int j = 0; j <= kSteps; ++j) {
      surfel.position_in_world = pose * (corner + a * i / kSteps + b * j / kSteps);
      map->Append(surfel);
    }
  }
}

// 6 m wide, 3 m high, 5 m deep; its frame is x right, y down, z forward, the origin 1.5 m above the
// middle of the floor's near edge.
SurfelMap Room(const Rigid3d& world_from_room) {
  SurfelMap map;
  AppendPlane(kFloor, {-3, 1.5, 0}, {6, 0, 0}, {0, 0, 5}, world_from_room, &map);
  AppendPlane(kCeiling, {-3, -1.5, 0}, {0, 0, 5}, {6, 0, 0}, world_from_room, &map);
  AppendPlane(kFrontWall, {-3, -1.5, 5}, {0, 3, 0}, {6, 0, 0}, world_from_room, &map);
  AppendPlane(kRightWall, {3, -1.5, 5}, {0, 3, 0}, {0, 0, -5}, world_from_room, &map);
  return map;
}

// A hand-held path that looks ahead, then to the right, and downwards by 0.4 to 0.6 rad.
Trajectory LookAround(const Rigid3d& world_from_room) {
  Trajectory path;
  for (int i = 0; i <= 10; ++i) {
    StampedPose pose;
    pose.world_from_camera.rotation =
        Eigen::AngleAxisd(0.1 * i, Eigen::Vector3d::UnitY()) *
        Eigen::AngleAxisd(i % 2 ? -0.6 : -0.4, Eigen::Vector3d::UnitX());
    pose.world_from_camera = world_from_room * pose.world_from_camera;
    path.push_back(pose);
  }
  return path;
}

class MapViewsTest : public ::testing::Test {
 protected:
  // Gravity along no axis of the world.
  const Rigid3d world_from_room_{
      Eigen::Quaterniond(Eigen::AngleAxisd(2, Eigen::Vector3d(1, -2, 0.5).normalized())),
      Eigen::Vector3d(3, -1, 7)};
  const SurfelMap map_ = Room(world_from_room_);
  const std::vector<std::uint8_t> all_ = std::vector<std::uint8_t>(map_.id_end(), 1);
  const std::array<PictureView, 4> views_ =
      ChooseMapViews(map_, all_, LookAround(world_from_room_), kViewWidth, kViewHeight);

  Eigen::Vector2d Project(int view, const Eigen::Vector3d& point_in_room) const {
    return views_[view].camera.Project(views_[view].camera_from_world *
                                       (world_from_room_ * point_in_room));
  }
  // The share of the view's pixels that show this part of the room.
  double Share(int view, Part part) const {
    const Image<std::int32_t> seen = RenderSurfels(map_, all_, views_[view]);
    return std::count_if(seen.begin(), seen.end(),
                         [&](int i) {
                           return i != NearestIndexImage::kNothing && map_[i].first_seen == part;
                         }) /
           static_cast<double>(seen.size());
  }
};

TEST_F(MapViewsTest, FromAboveOneLooksThroughTheCeilingAtTheFloor) {
  EXPECT_GT(Share(0, kFloor), 0.7);  // 6 m x 5 m in a picture of 4 : 3 fill 90 % of 0.94^2
  EXPECT_EQ(Share(0, kCeiling), 0);
}

TEST_F(MapViewsTest, FromAboveTheWallsStandUprightAndNothingIsMirrored) {
  const Eigen::Vector2d near_left = Project(0, {-3, 1.5, 0}), near_right = Project(0, {3, 1.5, 0});
  const Eigen::Vector2d far_left = Project(0, {-3, 1.5, 5});
  // The room's width lies across the page, what is ahead of the first camera above.
  EXPECT_GT(near_right.x() - near_left.x(), 0.8 * kViewWidth);
  EXPECT_NEAR(near_right.y(), near_left.y(), 0.02 * kViewWidth);
  EXPECT_LT(far_left.y() - near_left.y(), -0.8 * kViewHeight);
  // The walls' height of 3 m is seen end on, from four times at least the 8.4 m of the room's
  // diagonal: it makes at most 3 / 33 of the way from the picture's middle, here 56 pixels.
  const double wall_px = (Project(0, {0, -1.5, 5}) - Project(0, {0, 1.5, 5})).norm();
  EXPECT_LT(wall_px, 56 * 3 / 33. + 1);
}

TEST_F(MapViewsTest, TheBirdSeesFloorAndWallsButNotTheCeiling) {
  EXPECT_GT(Share(1, kFloor), 0.1);
  EXPECT_GT(Share(1, kFrontWall), 0.1);
  EXPECT_GT(Share(1, kRightWall), 0.1);
  EXPECT_EQ(Share(1, kCeiling), 0);
  EXPECT_LT(Project(1, {0, -1.5, 5}).y(), Project(1, {0, 1.5, 5}).y());  // up is up
}

TEST_F(MapViewsTest, TheFirstCameraIsPulledBack) {
  const Eigen::Vector3d eye_in_room =
      world_from_room_.Inverse() *
      (views_[2].camera_from_world.Inverse() * Eigen::Vector3d::Zero());
  EXPECT_LT(eye_in_room.z(), -0.5);  // 20 % of the median depth, which is between 3 and 5 m
  EXPECT_GT(eye_in_room.z(), -1);
  EXPECT_GT(Share(2, kFrontWall), 0.1);
  EXPECT_LT(Project(2, {-1, 0, 5}).x(), Project(2, {1, 0, 5}).x());
}

TEST_F(MapViewsTest, TheOtherCameraLooksElsewhere) {
  EXPECT_EQ(views_[3].label, "camera 11 of 11, pulled back");
  EXPECT_GT(Share(3, kRightWall), Share(2, kRightWall));
}

TEST(MostDifferentPose, WeighsAngleAgainstDistance) {
  Trajectory path(3);
  path[1].world_from_camera.translation = {1, 0, 0};
  path[2].world_from_camera.rotation = Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitY());
  EXPECT_EQ(MostDifferentPose(path, 1), 1u);   // 1 against 0.5
  EXPECT_EQ(MostDifferentPose(path, 10), 2u);  // 0.1 against 0.5
  EXPECT_EQ(MostDifferentPose(Trajectory(1), 1), 0u);
}

constexpr double kExact = 1e-9;

StampedPose Turned(double angle_rad, const Eigen::Vector3d& axis) {
  StampedPose pose;
  pose.world_from_camera.rotation = Eigen::AngleAxisd(angle_rad, axis);
  return pose;
}

TEST(UpDirection, IsTheMeanOfTheCamerasUpwardAxes) {
  const Trajectory nodding = {
      Turned(0.3, Eigen::Vector3d::UnitX()), Turned(-0.3, Eigen::Vector3d::UnitX()),
      Turned(0.2, Eigen::Vector3d::UnitZ()), Turned(-0.2, Eigen::Vector3d::UnitZ())};
  EXPECT_THAT(UpDirection(nodding), VectorNear(Eigen::Vector3d(0, -1, 0), kExact));
}

TEST(UpDirection, HoldsInAWorldWhoseZIsUp) {
  // Looking along the world's y: camera z -> y, camera y (down) -> -z.
  const Trajectory path = {Turned(-M_PI / 2, Eigen::Vector3d::UnitX())};
  EXPECT_THAT(UpDirection(path), VectorNear(Eigen::Vector3d(0, 0, 1), kExact));
}

TEST(UpDirection, OfOppositeCamerasIsTheFirstOnes) {
  const Trajectory path = {Turned(0, Eigen::Vector3d::UnitZ()),
                           Turned(M_PI, Eigen::Vector3d::UnitZ())};
  EXPECT_THAT(UpDirection(path), VectorNear(Eigen::Vector3d(0, -1, 0), kExact));
  EXPECT_THAT(UpDirection({}), VectorNear(Eigen::Vector3d(0, -1, 0), kExact));
}

TEST(LookAlong, PutsForwardAheadUpUpwardsAndDoesNotMirror) {
  const Eigen::Vector3d eye(1, 2, 3), forward(1, 0, 0.5), up(0, 0, 2);
  const Rigid3d camera_from_world = LookAlong(eye, forward, up);
  EXPECT_THAT(camera_from_world * eye, VectorNear(Eigen::Vector3d(0, 0, 0), kExact));
  EXPECT_THAT(camera_from_world * (eye + forward.normalized()),
              VectorNear(Eigen::Vector3d(0, 0, 1), kExact));
  const Eigen::Vector3d up_in_camera = camera_from_world.rotation * up;
  EXPECT_NEAR(up_in_camera.x(), 0, kExact);
  EXPECT_LT(up_in_camera.y(), 0);
  // Who looks along x with z up has -y to the right.
  EXPECT_GT((camera_from_world.rotation * -Eigen::Vector3d::UnitY()).x(), 0.99);
}

TEST(FitCamera, FillsTheImageButForTheMargin) {
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i <= 100; ++i) {
    for (int j = 0; j <= 100; ++j) {
      points.push_back({0.02f * i, 0.02f * (0.01f * i) * j / 2 - 0.3f, 2});  // x / z from 0 to 1
    }
  }
  points.push_back({0, 0, -1});
  const PinholeCamera camera = FitCamera(points, 800, 600);
  EXPECT_EQ(camera.fx, camera.fy);
  // The outer columns hold 1 % of the points each, so the 0.5 % quantiles are 0 and 1.
  EXPECT_NEAR(camera.fx, 0.94 * 800, 1e-3);
  EXPECT_NEAR(camera.Project({0, 0, 2}).x(), 0.03 * 800 - 0.5, 1e-3);
  EXPECT_NEAR(camera.Project({2, 0, 2}).x(), 0.97 * 800 - 0.5, 1e-3);
}

TEST(FitCamera, OfNothingIsStillACamera) { EXPECT_NO_THROW(FitCamera({}, 80, 60).Validate("x")); }

TEST(Quantile, PicksTheValueOfThatRank) {
  EXPECT_EQ(Quantile({3, 1, 2}, 0, 9), 1);
  EXPECT_EQ(Quantile({3, 1, 2}, 0.5, 9), 2);
  EXPECT_EQ(Quantile({3, 1, 2}, 1, 9), 3);
  EXPECT_EQ(Quantile({}, 0.5, 9), 9);
}

}  // namespace
}  // namespace surfit::testing
