#include "pictures/picture_view.h"

#include <gtest/gtest.h>

#include "testing/matchers.h"

namespace surfit {
namespace {

using testing::VectorNear;

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
}  // namespace surfit
