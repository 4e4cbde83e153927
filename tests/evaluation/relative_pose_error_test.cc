#include "surfit/evaluation/relative_pose_error.h"

#include <gtest/gtest.h>

#include <cmath>

#include "evaluation/square_trajectory.h"
#include "surfit/core/error.h"
#include "testing/random_pose.h"

namespace surfit {
namespace {

using testing::RandomPose;
using testing::SquareWithALiftedCorner;
using Unit = RelativePoseErrorOptions::Unit;

// The two steps that touch the lifted corner are off by the lift h, the other one by 0.
TEST(RelativePoseError, OfASquareWithALiftedCorner) {
  const auto rpe = ComputeRelativePoseError(SquareWithALiftedCorner(0.3), {});
  ASSERT_TRUE(rpe.has_value());
  EXPECT_EQ(rpe->translation_m.count, 3u);
  EXPECT_NEAR(rpe->translation_m.rmse, 0.3 * std::sqrt(2. / 3), 1e-12);
  EXPECT_NEAR(rpe->translation_m.mean, 0.2, 1e-12);
  EXPECT_NEAR(rpe->translation_m.median, 0.3, 1e-12);
  EXPECT_EQ(rpe->rotation_deg.max, 0);
}

// Over 2 poses: 0 -> 2 is off by h, 1 -> 3 by nothing.
TEST(RelativePoseError, TakesItsStepInPoses) {
  const auto rpe = ComputeRelativePoseError(SquareWithALiftedCorner(0.3), {2, Unit::kFrames});
  EXPECT_EQ(rpe->translation_m.count, 2u);
  EXPECT_NEAR(rpe->translation_m.rmse, 0.3 * std::sqrt(1. / 2), 1e-12);
}

// The truth stands still; the estimate turns by 2 degrees a frame about its own z axis and goes
// 0.1 m along its own x axis: each step is wrong by exactly that, whatever the heading.
TEST(RelativePoseError, OfASteadyDriftIsTheDrift) {
  const double turn_rad = 2 * std::acos(-1) / 180;
  const Rigid3d step(QuaternionExp<double>({0, 0, turn_rad}), {0.1, 0, 0});
  std::vector<MatchedPose> poses(100);
  for (std::size_t i = 1; i < poses.size(); ++i) poses[i].estimate = poses[i - 1].estimate * step;
  const auto rpe = ComputeRelativePoseError(poses, {});
  EXPECT_NEAR(rpe->translation_m.rmse, 0.1, 1e-12);
  EXPECT_NEAR(rpe->rotation_deg.rmse, 2, 1e-10);
  EXPECT_NEAR(rpe->rotation_deg.max, 2, 1e-10);
}

// Q_i^-1 Q_j = a turn of 90 degrees about z and 1 m along x; P_i^-1 P_j = 1 m along x, no turn.
// E = (Rz90, (1,0,0))^-1 (I, (1,0,0)) = (Rz-90, 0): the translations cancel in the frame of i.
TEST(RelativePoseError, ComparesMotionsFromTheFirstPoseToTheSecond) {
  std::vector<MatchedPose> poses(2);
  const double quarter_rad = std::acos(-1) / 2;
  poses[1].ground_truth = Rigid3d(QuaternionExp<double>({0, 0, quarter_rad}), {1, 0, 0});
  poses[1].estimate.translation = {1, 0, 0};
  const auto rpe = ComputeRelativePoseError(poses, {});
  EXPECT_NEAR(rpe->translation_m.max, 0, 1e-12);
  EXPECT_NEAR(rpe->rotation_deg.max, 90, 1e-10);
}

TEST(RelativePoseError, DoesNotDependOnEitherWorld) {
  std::mt19937_64 rng(1);
  std::vector<MatchedPose> poses(20);
  for (MatchedPose& pose : poses) {
    pose.ground_truth = RandomPose(1, 2, &rng);
    pose.estimate = pose.ground_truth * RandomPose(0.1, 0.1, &rng);
  }
  const auto before = ComputeRelativePoseError(poses, {});
  const Rigid3d a = RandomPose(1.8, 5, &rng), b = RandomPose(1.8, 5, &rng);
  for (MatchedPose& pose : poses) {
    pose.ground_truth = a * pose.ground_truth;
    pose.estimate = b * pose.estimate;
  }
  const auto after = ComputeRelativePoseError(poses, {});
  EXPECT_NEAR(after->translation_m.rmse, before->translation_m.rmse, 1e-12);
  EXPECT_NEAR(after->rotation_deg.rmse, before->rotation_deg.rmse, 1e-10);
}

// Stamps 0, 1, 2, 5 with h = 0.3 at the third: a second later than 0 and 1 there are poses, than
// 2 and 5 there are none (3 would be nearest to 2, wrong by more than a tenth of a second).
TEST(RelativePoseError, TakesItsStepInSeconds) {
  auto poses = SquareWithALiftedCorner(0.3);
  poses[3].stamp_s = 5;
  const auto rpe = ComputeRelativePoseError(poses, {1, Unit::kSeconds});
  EXPECT_EQ(rpe->translation_m.count, 2u);
  EXPECT_NEAR(rpe->translation_m.rmse, 0.3 * std::sqrt(1. / 2), 1e-12);
  // 2.05 s: 0 -> 2 alone, off by 0.05 s of 0.205 s.
  EXPECT_EQ(ComputeRelativePoseError(poses, {2.05, Unit::kSeconds})->translation_m.count, 1u);
}

TEST(RelativePoseError, OfNoPairIsNothing) {
  const auto poses = SquareWithALiftedCorner(0.3);
  EXPECT_FALSE(ComputeRelativePoseError({}, {}).has_value());
  EXPECT_FALSE(ComputeRelativePoseError(poses, {4, Unit::kFrames}).has_value());
  EXPECT_FALSE(ComputeRelativePoseError(poses, {0.5, Unit::kSeconds}).has_value());
}

TEST(RelativePoseErrorOptions, ValidateRefusesNonsense) {
  EXPECT_NO_THROW((RelativePoseErrorOptions{0.5, Unit::kSeconds}.Validate()));
  EXPECT_THROW((RelativePoseErrorOptions{0.5, Unit::kFrames}.Validate()), InputError);
  EXPECT_THROW((RelativePoseErrorOptions{0, Unit::kFrames}.Validate()), InputError);
  EXPECT_THROW((RelativePoseErrorOptions{-1, Unit::kSeconds}.Validate()), InputError);
  EXPECT_THROW((RelativePoseErrorOptions{std::nan(""), Unit::kSeconds}.Validate()), InputError);
}

}  // namespace
}  // namespace surfit
