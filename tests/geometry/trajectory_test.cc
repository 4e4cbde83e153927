#include "surfit/geometry/trajectory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "testing/matchers.h"

namespace surfit {
namespace {

using testing::RigidNear;

Rigid3d Pose(double turn_rad, double x_m) {
  return Rigid3d(QuaternionExp<double>({0, turn_rad, 0}), {x_m, 0, 0});
}

// A gap of 0.1 s, then one of 1 s.
const Trajectory kTrajectory = {{1.0, Pose(0, 0)}, {1.1, Pose(0.4, 2)}, {2.1, Pose(1, 5)}};

TEST(InterpolatePose, IsLinearBetweenNearPoses) {
  const auto pose = InterpolatePose(kTrajectory, 1.025, 0.11);
  ASSERT_TRUE(pose);
  EXPECT_THAT(*pose, RigidNear(Pose(0.1, 0.5), 1e-12, 1e-12));
}

TEST(InterpolatePose, IsExactAtAStamp) {
  EXPECT_THAT(*InterpolatePose(kTrajectory, 1.1), RigidNear(Pose(0.4, 2), 0, 0));
}

TEST(InterpolatePose, TakesTheNearestBesideAWideGapAndAtTheEnds) {
  EXPECT_THAT(*InterpolatePose(kTrajectory, 1.115), RigidNear(Pose(0.4, 2), 0, 0));
  EXPECT_THAT(*InterpolatePose(kTrajectory, 2.085), RigidNear(Pose(1, 5), 0, 0));
  EXPECT_THAT(*InterpolatePose(kTrajectory, 0.985), RigidNear(Pose(0, 0), 0, 0));
  EXPECT_THAT(*InterpolatePose(kTrajectory, 2.115), RigidNear(Pose(1, 5), 0, 0));
}

TEST(InterpolatePose, KnowsNothingFarFromAllPoses) {
  EXPECT_FALSE(InterpolatePose(kTrajectory, 1.5));
  EXPECT_FALSE(InterpolatePose(kTrajectory, 0.9));
  EXPECT_FALSE(InterpolatePose(kTrajectory, 2.2));
  EXPECT_FALSE(InterpolatePose({}, 1));
}

}  // namespace
}  // namespace surfit
