#include "output/pictures/map_views.h"

#include <gtest/gtest.h>

#include "output/pictures/picture_view.h"
#include "output/pictures/splat_renderer.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

constexpr int kViewWidth = 160, kViewHeight = 120;
// Part of the room. The field first_seen of surfels stores it.
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

// A room of 6 x 3 x 5 m (width, height, depth). Its frame is x right, y down, z forward. The origin
// is 1.5 m above the centre of the near edge of the floor.
SurfelMap Room(const Rigid3d& world_from_room) {
  SurfelMap map;
  AppendPlane(kFloor, {-3, 1.5, 0}, {6, 0, 0}, {0, 0, 5}, world_from_room, &map);
  AppendPlane(kCeiling, {-3, -1.5, 0}, {0, 0, 5}, {6, 0, 0}, world_from_room, &map);
  AppendPlane(kFrontWall, {-3, -1.5, 5}, {0, 3, 0}, {6, 0, 0}, world_from_room, &map);
  AppendPlane(kRightWall, {3, -1.5, 5}, {0, 3, 0}, {0, 0, -5}, world_from_room, &map);
  return map;
}

// A trajectory that looks forward, then to the right, and down by 0.4 to 0.6 rad.
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
  // Gravity is not along an axis of the world frame.
  const Rigid3d world_from_room_{
      Eigen::Quaterniond(Eigen::AngleAxisd(2, Eigen::Vector3d(1, -2, 0.5).normalized())),
      Eigen::Vector3d(3, -1, 7)};
  const SurfelMap map_ = Room(world_from_room_);
  const std::vector<std::uint8_t> all_ = std::vector<std::uint8_t>(map_.id_end(), 1);
  const std::array<PictureView, 4> views_ = ChooseMapViews(map_, all_, LookAround(world_from_room_),
                                                           std::nullopt, kViewWidth, kViewHeight);

  Eigen::Vector2d Project(int view, const Eigen::Vector3d& point_in_room) const {
    return views_[view].camera.Project(views_[view].camera_from_world *
                                       (world_from_room_ * point_in_room));
  }
  // Ratio of pixels of the view that show this part of the room.
  double Share(int view, Part part) const {
    const Image<std::int32_t> seen = RenderSurfels(map_, all_, views_[view]);
    return std::count_if(seen.begin(), seen.end(),
                         [&](int i) {
                           return i != NearestIndexImage::kNothing && map_[i].first_seen == part;
                         }) /
           static_cast<double>(seen.size());
  }
};

TEST_F(MapViewsTest, TopViewShowsTheFloorThroughTheCeiling) {
  EXPECT_GT(Share(0, kFloor), 0.7);  // 6 m x 5 m in an image of 4 : 3 fill 90 % of 0.94^2
  EXPECT_EQ(Share(0, kCeiling), 0);
}

TEST_F(MapViewsTest, TopViewIsUprightAndNotMirrored) {
  const Eigen::Vector2d near_left = Project(0, {-3, 1.5, 0}), near_right = Project(0, {3, 1.5, 0});
  const Eigen::Vector2d far_left = Project(0, {-3, 1.5, 5});
  // The width of the room is horizontal, and the forward direction of the first camera is up.
  EXPECT_GT(near_right.x() - near_left.x(), 0.8 * kViewWidth);
  EXPECT_NEAR(near_right.y(), near_left.y(), 0.02 * kViewWidth);
  EXPECT_LT(far_left.y() - near_left.y(), -0.8 * kViewHeight);
  // The wall of 3 m height is seen from a distance of at least four times the room diagonal of 8.4
  // m. Its length is at most 3 / 33 of the distance to the image centre, here 56 pixels.
  const double wall_px = (Project(0, {0, -1.5, 5}) - Project(0, {0, 1.5, 5})).norm();
  EXPECT_LT(wall_px, 56 * 3 / 33. + 1);
}

TEST_F(MapViewsTest, BirdsEyeViewShowsFloorAndWallsWithoutCeiling) {
  EXPECT_GT(Share(1, kFloor), 0.1);
  EXPECT_GT(Share(1, kFrontWall), 0.1);
  EXPECT_GT(Share(1, kRightWall), 0.1);
  EXPECT_EQ(Share(1, kCeiling), 0);
  EXPECT_LT(Project(1, {0, -1.5, 5}).y(), Project(1, {0, 1.5, 5}).y());  // up is up in the image
}

TEST_F(MapViewsTest, FirstCameraViewIsBehindTheFirstCamera) {
  const Eigen::Vector3d eye_in_room =
      world_from_room_.Inverse() *
      (views_[2].camera_from_world.Inverse() * Eigen::Vector3d::Zero());
  EXPECT_LT(eye_in_room.z(), -0.5);  // 20 % of the median depth, 3 to 5 m
  EXPECT_GT(eye_in_room.z(), -1);
  EXPECT_GT(Share(2, kFrontWall), 0.1);
  EXPECT_LT(Project(2, {-1, 0, 5}).x(), Project(2, {1, 0, 5}).x());
}

TEST_F(MapViewsTest, SecondCameraViewHasAnotherDirection) {
  EXPECT_THAT(views_[3].label, Names(11));
  EXPECT_GT(Share(3, kRightWall), Share(2, kRightWall));
}

TEST_F(MapViewsTest, GivenUprightWorldDecidesTheTopView) {
  const Eigen::Quaterniond tilt(Eigen::AngleAxisd(0.2, Eigen::Vector3d(1, 2, 0.3).normalized()));
  UprightWorld upright;
  upright.upright_from_world = Rigid3d(tilt, {0, 0, 0});
  for (const bool walls_give_axes : {false, true}) {
    upright.walls_give_axes = walls_give_axes;
    const PictureView top = ChooseMapViews(map_, all_, LookAround(world_from_room_), upright,
                                           kViewWidth, kViewHeight)[0];
    const Eigen::Matrix3d upright_from_view =
        (tilt * top.camera_from_world.rotation.conjugate()).toRotationMatrix();
    EXPECT_THAT(upright_from_view.col(2), VectorNear(Eigen::Vector3d(0, 0, -1), 1e-9));
    const double off_axis = upright_from_view.col(0).cwiseAbs().maxCoeff();
    EXPECT_EQ(off_axis > 1 - 1e-9, walls_give_axes);
  }
}

TEST(MostDifferentPose, WeighsAngleAgainstDistance) {
  Trajectory path(3);
  path[1].world_from_camera.translation = {1, 0, 0};
  path[2].world_from_camera.rotation = Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitY());
  EXPECT_EQ(MostDifferentPose(path, 1), 1u);   // 1 versus 0.5
  EXPECT_EQ(MostDifferentPose(path, 10), 2u);  // 0.1 versus 0.5
  EXPECT_EQ(MostDifferentPose(Trajectory(1), 1), 0u);
}

constexpr double kExact = 1e-9;

StampedPose Turned(double angle_rad, const Eigen::Vector3d& axis) {
  StampedPose pose;
  pose.world_from_camera.rotation = Eigen::AngleAxisd(angle_rad, axis);
  return pose;
}

TEST(UpDirection, IsTheMeanUpAxisOfTheCameras) {
  const Trajectory nodding = {
      Turned(0.3, Eigen::Vector3d::UnitX()), Turned(-0.3, Eigen::Vector3d::UnitX()),
      Turned(0.2, Eigen::Vector3d::UnitZ()), Turned(-0.2, Eigen::Vector3d::UnitZ())};
  EXPECT_THAT(UpDirection(nodding), VectorNear(Eigen::Vector3d(0, -1, 0), kExact));
}

TEST(UpDirection, IsZInAWorldWithZUp) {
  // The camera looks along world y: camera z -> y, camera y (down) -> -z.
  const Trajectory path = {Turned(-M_PI / 2, Eigen::Vector3d::UnitX())};
  EXPECT_THAT(UpDirection(path), VectorNear(Eigen::Vector3d(0, 0, 1), kExact));
}

TEST(UpDirection, OfOppositeCamerasIsThatOfTheFirst) {
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
  // Right is -y for a view along x with z up.
  EXPECT_GT((camera_from_world.rotation * -Eigen::Vector3d::UnitY()).x(), 0.99);
}

TEST(FitCamera, FillsTheImageExceptTheMargin) {
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i <= 100; ++i) {
    for (int j = 0; j <= 100; ++j) {
      points.push_back({0.02f * i, 0.02f * (0.01f * i) * j / 2 - 0.3f, 2});  // x / z from 0 to 1
    }
  }
  points.push_back({0, 0, -1});
  const PinholeCamera camera = FitCamera(points, 800, 600);
  EXPECT_EQ(camera.fx, camera.fy);
  // Each outer column has 1 % of the points, so the 0.5 % quantiles are 0 and 1.
  EXPECT_NEAR(camera.fx, 0.94 * 800, 1e-3);
  EXPECT_NEAR(camera.Project({0, 0, 2}).x(), 0.03 * 800 - 0.5, 1e-3);
  EXPECT_NEAR(camera.Project({2, 0, 2}).x(), 0.97 * 800 - 0.5, 1e-3);
}

TEST(FitCamera, IsValidWithoutPoints) { EXPECT_NO_THROW(FitCamera({}, 80, 60).Validate("x")); }

TEST(Quantile, PicksTheValueOfThatRank) {
  EXPECT_EQ(Quantile({3, 1, 2}, 0, 9), 1);
  EXPECT_EQ(Quantile({3, 1, 2}, 0.5, 9), 2);
  EXPECT_EQ(Quantile({3, 1, 2}, 1, 9), 3);
  EXPECT_EQ(Quantile({}, 0.5, 9), 9);
}

}  // namespace
}  // namespace surfit::testing
