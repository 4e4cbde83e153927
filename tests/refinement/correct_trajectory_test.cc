#include "surfit/refinement/correct_trajectory.h"

#include <gtest/gtest.h>

#include "testing/matchers.h"

namespace surfit {
namespace {

using testing::RigidNear;

// A camera that goes 1 cm a frame along x, 30 frames a second.
Trajectory Straight(int count) {
  Trajectory trajectory;
  for (int i = 0; i < count; ++i) {
    trajectory.push_back({i / 30., Rigid3d(Eigen::Quaterniond::Identity(), {0.01 * i, 0, 0})});
  }
  return trajectory;
}

TEST(ChooseKeyframes, TakesTheFirstAndEachThatHasMoved) {
  EXPECT_EQ(ChooseKeyframes(Straight(10), 0.035, 1, 0), (std::vector<std::size_t>{0, 4, 8}));
  EXPECT_TRUE(ChooseKeyframes({}, 0.1, 1, 0).empty());
}

TEST(ChooseKeyframes, TakesThoseThatHaveTurned) {
  Trajectory turning = Straight(3);
  turning[2].world_from_camera.rotation = QuaternionExp<double>({0, 0.2, 0});
  EXPECT_EQ(ChooseKeyframes(turning, 1, 0.15, 0), (std::vector<std::size_t>{0, 2}));
}

TEST(ChooseKeyframes, TakesFewerWhereThereWouldBeTooMany) {
  const std::vector<std::size_t> chosen = ChooseKeyframes(Straight(1000), 0.015, 1, 20);
  EXPECT_LE(chosen.size(), 20u);
  EXPECT_GT(chosen.size(), 10u);
}

TEST(CorrectTrajectory, KeepsPosesWhoseKeyframesDoNotMove) {
  const Trajectory given = Straight(7);
  const Trajectory same = CorrectTrajectory(
      given, {0, 3, 5},
      {given[0].world_from_camera, given[3].world_from_camera, given[5].world_from_camera});
  for (std::size_t i = 0; i < given.size(); ++i) {
    EXPECT_THAT(same[i].world_from_camera, RigidNear(given[i].world_from_camera, 1e-12, 1e-12));
  }
}

TEST(CorrectTrajectory, InterpolatesWhatItsKeyframesDid) {
  const Trajectory given = Straight(7);
  const Rigid3d up(Eigen::Quaterniond::Identity(), {0, 0, 0.04});
  const Trajectory moved = CorrectTrajectory(
      given, {0, 4}, {given[0].world_from_camera, up * given[4].world_from_camera});
  EXPECT_THAT(moved[1].world_from_camera,
              RigidNear(Rigid3d(Eigen::Quaterniond::Identity(), {0.01, 0, 0.01}), 1e-12, 1e-12));
  EXPECT_THAT(moved[4].world_from_camera, RigidNear(up * given[4].world_from_camera, 1e-12, 1e-12));
  // Beyond the last keyframe all move with it.
  EXPECT_THAT(moved[6].world_from_camera, RigidNear(up * given[6].world_from_camera, 1e-12, 1e-12));
  EXPECT_EQ(moved[6].stamp_s, given[6].stamp_s);
}

}  // namespace
}  // namespace surfit
