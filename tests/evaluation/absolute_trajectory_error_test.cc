#include "surfit/evaluation/absolute_trajectory_error.h"

#include <gtest/gtest.h>

#include <cmath>

#include "evaluation/square_trajectory.h"
#include "testing/matchers.h"
#include "testing/random_pose.h"

namespace surfit {
namespace {

using testing::RandomPose;
using testing::RigidNear;
using testing::SquareWithALiftedCorner;

TEST(AbsoluteTrajectoryError, OfASquareWithALiftedCornerIsAQuarterOfTheLift) {
  const double lift_m = 1e-3;
  const auto ate = ComputeAbsoluteTrajectoryError(SquareWithALiftedCorner(lift_m));
  ASSERT_TRUE(ate.has_value());
  EXPECT_EQ(ate->translation_m.count, 4u);
  // The tilt of h/4 shortens the sides by (h/4)^2/2 and the like: h^2 bounds the second order.
  for (const double error : {ate->translation_m.rmse, ate->translation_m.mean,
                             ate->translation_m.median, ate->translation_m.max}) {
    EXPECT_NEAR(error, lift_m / 4, lift_m * lift_m);
  }
}

// Both ends of a line of 3 poses at -1, 0, 1 m pulled apart to -1.5, 0, 1.5: nothing rigid helps,
// so the errors are 0.5, 0, 0.5. The line leaves the rotation about itself open.
TEST(AbsoluteTrajectoryError, OfAStretchedLineIsItsStretch) {
  std::vector<MatchedPose> poses(3);
  for (int i = 0; i < 3; ++i) {
    poses[i].ground_truth.translation.y() = i - 1;
    poses[i].estimate.translation.y() = 1.5 * (i - 1);
  }
  const auto ate = ComputeAbsoluteTrajectoryError(poses);
  ASSERT_TRUE(ate.has_value());
  EXPECT_EQ(ate->alignment.status, AlignmentStatus::kRotationNotUnique);
  EXPECT_NEAR(ate->translation_m.rmse, std::sqrt(0.5 / 3), 1e-12);
  EXPECT_NEAR(ate->translation_m.mean, 1. / 3, 1e-12);
  EXPECT_NEAR(ate->translation_m.median, 0.5, 1e-12);
  EXPECT_NEAR(ate->translation_m.max, 0.5, 1e-12);
}

// A square with sides 2 m scaled by 1.1: each corner, sqrt(2) m from the centre, is off by a tenth
// of that. With scale the error would be 0.
TEST(AbsoluteTrajectoryError, DoesNotAdjustScale) {
  auto poses = SquareWithALiftedCorner(0);
  for (MatchedPose& pose : poses) pose.estimate.translation *= 1.1;
  EXPECT_NEAR(ComputeAbsoluteTrajectoryError(poses)->translation_m.rmse, 0.1 * std::sqrt(2.),
              1e-12);
}

TEST(AbsoluteTrajectoryError, DoesNotDependOnEitherWorld) {
  std::mt19937_64 rng(1);
  auto poses = SquareWithALiftedCorner(0.3);
  const auto before = ComputeAbsoluteTrajectoryError(poses);
  const Rigid3d a = RandomPose(1.8, 5, &rng), b = RandomPose(1.8, 5, &rng);
  for (MatchedPose& pose : poses) {
    pose.ground_truth = a * pose.ground_truth;
    pose.estimate = b * pose.estimate;
  }
  const auto after = ComputeAbsoluteTrajectoryError(poses);
  EXPECT_NEAR(after->translation_m.rmse, before->translation_m.rmse, 1e-12);
  EXPECT_NEAR(after->translation_m.max, before->translation_m.max, 1e-12);
  EXPECT_THAT(after->alignment.target_from_source,
              RigidNear(a * before->alignment.target_from_source * b.Inverse(), 1e-12, 1e-12));
}

TEST(AbsoluteTrajectoryError, NeedsThreePoses) {
  auto poses = SquareWithALiftedCorner(0);
  poses.resize(2);
  EXPECT_FALSE(ComputeAbsoluteTrajectoryError(poses).has_value());
}

}  // namespace
}  // namespace surfit
