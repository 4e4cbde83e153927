#include "surfit/evaluation/trajectory_evaluation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/evaluation/error_statistics.h"
#include "testing/matchers.h"
#include "testing/random_pose.h"

namespace surfit::testing {
namespace {

// Corners of a square with side 2 m around the origin, in the plane z = 0, looking along z, with
// the timestamps 0, 1, 2, 3. One corner of the estimate is lifted by `lift_m`.
//
// ATE by hand: the only error is the lift h along z at corner (1, 1). To first order in h, the best
// rigid motion is the plane z = a + b x + c y that is fitted to (0, 0, h, 0) at the corners.
// Its parameters are a = b = c = h/4. The coordinates x and y change in second order only. The fit
// has 3 parameters for 4 values. The remaining component is along (1, -1, 1, -1)/2: the error of
// every corner is h/4, so rmse = mean = median = max = h/4.
std::vector<MatchedPose> SquareWithALiftedCorner(double lift_m) {
  const Eigen::Vector3d corners[] = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  std::vector<MatchedPose> poses(4);
  for (int i = 0; i < 4; ++i) {
    poses[i].stamp_s = i;
    poses[i].ground_truth.translation = poses[i].estimate.translation = corners[i];
  }
  poses[2].estimate.translation.z() += lift_m;
  return poses;
}

TEST(Summarize, ComputesStatisticsOfKnownSet) {
  // Sorted 1 2 3 6: the rank of the median is 1.5, and the rank of 90 % is 0.9 * 3 = 2.7.
  const ErrorStatistics s = Summarize({6, 1, 3, 2});
  EXPECT_EQ(s.count, 4u);
  EXPECT_DOUBLE_EQ(s.rmse, std::sqrt((36 + 1 + 9 + 4) / 4.));
  EXPECT_DOUBLE_EQ(s.mean, 3);
  EXPECT_DOUBLE_EQ(s.median, 2.5);
  EXPECT_DOUBLE_EQ(s.p90, 3 + 0.7 * 3);
  EXPECT_DOUBLE_EQ(s.max, 6);
}

TEST(Summarize, IsTheErrorForSingleError) {
  const ErrorStatistics s = Summarize({0.25});
  for (const double value : {s.rmse, s.mean, s.median, s.p90, s.max}) EXPECT_EQ(value, 0.25);
}

TEST(MatchOptions, ValidateRejectsInvalidValues) {
  EXPECT_THROW(Validate(MatchOptions{0.01, -0.1}), InputError);
  EXPECT_NO_THROW(Validate(MatchOptions{0}));
  EXPECT_THROW(Validate(MatchOptions{-0.1}), InputError);
  EXPECT_THROW(Validate(MatchOptions{1.1}), InputError);
  EXPECT_THROW(Validate(MatchOptions{std::numeric_limits<double>::quiet_NaN()}), InputError);
}

TEST(MatchPoses, ContainsBothPosesAndTimestampOfEstimate) {
  Trajectory ground_truth(2), estimate(1);
  ground_truth[0] = {5.0, Rigid3d(Eigen::Quaterniond::Identity(), {1, 0, 0})};
  ground_truth[1] = {6.0, Rigid3d(Eigen::Quaterniond::Identity(), {2, 0, 0})};
  estimate[0] = {6.005, Rigid3d(Eigen::Quaterniond::Identity(), {3, 0, 0})};
  const auto poses = MatchPoses(ground_truth, estimate, MatchOptions());
  ASSERT_EQ(poses.size(), 1u);
  EXPECT_EQ(poses[0].stamp_s, 6.005);
  EXPECT_EQ(poses[0].ground_truth.translation.x(), 2);
  EXPECT_EQ(poses[0].estimate.translation.x(), 3);
}

// Camera with constant velocity along a line and constant rotation about an axis: linear
// interpolation is exact.
Trajectory Steady(int count, double period_s, double begin_s) {
  Trajectory trajectory;
  for (int i = 0; i < count; ++i) {
    const double t = begin_s + i * period_s;
    trajectory.push_back(
        {t, Rigid3d(QuaternionExp<double>(t * Eigen::Vector3d(0.4, -0.3, 0.9)),
                    Eigen::Vector3d(1, 2, 3) + t * Eigen::Vector3d(0.5, -0.2, 0.3))});
  }
  return trajectory;
}

TEST(MatchPoses, InterpolatesGroundTruthAtTimestampsOfEstimate) {
  const Trajectory ground_truth = Steady(101, 0.01, 0);
  const Trajectory estimate = Steady(28, 1 / 30., 0.0037);
  const auto poses = MatchPoses(ground_truth, estimate, MatchOptions());
  ASSERT_EQ(poses.size(), estimate.size());
  for (const MatchedPose& pose : poses) {
    EXPECT_THAT(pose.estimate, RigidNear(pose.ground_truth, 1e-12, 1e-12));
  }
  EXPECT_LT(ComputeAbsoluteTrajectoryError(poses)->translation_m.max, 1e-12);
}

TEST(MatchPoses, IsExactAtTimestampsOfGroundTruth) {
  const Trajectory ground_truth = Steady(31, 1 / 30., 1305031453.3);
  const auto poses = MatchPoses(ground_truth, ground_truth, MatchOptions());
  ASSERT_EQ(poses.size(), ground_truth.size());
  for (const MatchedPose& pose : poses) {
    EXPECT_EQ(pose.ground_truth.translation, pose.estimate.translation);
    EXPECT_EQ(pose.ground_truth.rotation.coeffs(), pose.estimate.rotation.coeffs());
  }
}

TEST(MatchPoses, UsesNearestPoseInWideGap) {
  const Trajectory ground_truth = Steady(3, 0.06, 0);
  const Trajectory estimate = {{0.009, Rigid3d()}, {0.03, Rigid3d()}, {0.125, Rigid3d()}};
  const auto poses = MatchPoses(ground_truth, estimate, MatchOptions());
  ASSERT_EQ(poses.size(), 2u);  // 0.03 s is too far from both poses
  EXPECT_EQ(poses[0].ground_truth.translation, ground_truth[0].world_from_camera.translation);
  EXPECT_EQ(poses[1].ground_truth.translation, ground_truth[2].world_from_camera.translation);
  MatchOptions wide;
  wide.max_gap_s = 0.07;
  EXPECT_THAT(MatchPoses(ground_truth, estimate, wide)[1].ground_truth,
              RigidNear(Steady(1, 1, 0.03)[0].world_from_camera, 1e-12, 1e-12));
  MatchOptions never;
  never.max_gap_s = 0;
  EXPECT_EQ(
      MatchPoses(Steady(11, 0.01, 0), {{0.043, Rigid3d()}}, never)[0].ground_truth.translation,
      Steady(11, 0.01, 0)[4].world_from_camera.translation);
}

TEST(AbsoluteTrajectoryError, IsQuarterOfLiftOfCorner) {
  const double lift_m = 1e-3;
  const auto ate = ComputeAbsoluteTrajectoryError(SquareWithALiftedCorner(lift_m));
  ASSERT_TRUE(ate.has_value());
  EXPECT_EQ(ate->translation_m.count, 4u);
  // The tilt of h/4 shortens the sides by (h/4)^2/2. The second order is below h^2.
  for (const double error : {ate->translation_m.rmse, ate->translation_m.mean,
                             ate->translation_m.median, ate->translation_m.max}) {
    EXPECT_NEAR(error, lift_m / 4, lift_m * lift_m);
  }
}

// The ends of a line of 3 poses at -1, 0, 1 m are moved to -1.5, 0, 1.5. No rigid motion reduces
// the errors 0.5, 0, 0.5. The rotation about the line is unobservable.
TEST(AbsoluteTrajectoryError, IsStretchOfLine) {
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

// A square with side 2 m is scaled by 1.1: the error of each corner is a tenth of its distance to
// the centre, sqrt(2) m. With scale alignment the error is 0.
TEST(AbsoluteTrajectoryError, DoesNotAlignScale) {
  auto poses = SquareWithALiftedCorner(0);
  for (MatchedPose& pose : poses) pose.estimate.translation *= 1.1;
  EXPECT_NEAR(ComputeAbsoluteTrajectoryError(poses)->translation_m.rmse, 0.1 * std::sqrt(2.),
              1e-12);
}

TEST(AbsoluteTrajectoryError, IsIndependentOfWorldFrames) {
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

using Unit = RelativePoseErrorOptions::Unit;

// The error of the two steps at the lifted corner is the lift h. The error of the third step is 0.
TEST(RelativePoseError, AgreesWithKnownSquare) {
  const auto rpe = ComputeRelativePoseError(SquareWithALiftedCorner(0.3), {});
  ASSERT_TRUE(rpe.has_value());
  EXPECT_EQ(rpe->translation_m.count, 3u);
  EXPECT_NEAR(rpe->translation_m.rmse, 0.3 * std::sqrt(2. / 3), 1e-12);
  EXPECT_NEAR(rpe->translation_m.mean, 0.2, 1e-12);
  EXPECT_NEAR(rpe->translation_m.median, 0.3, 1e-12);
  EXPECT_EQ(rpe->rotation_deg.max, 0);
}

// Over 2 poses: the error of 0 -> 2 is h, and the error of 1 -> 3 is 0.
TEST(RelativePoseError, SupportsStepInPoses) {
  const auto rpe = ComputeRelativePoseError(SquareWithALiftedCorner(0.3), {2, Unit::kFrames});
  EXPECT_EQ(rpe->translation_m.count, 2u);
  EXPECT_NEAR(rpe->translation_m.rmse, 0.3 * std::sqrt(1. / 2), 1e-12);
}

// The ground truth is constant. The estimate rotates by 2 degrees per frame about its z axis and
// moves by 0.1 m along its x axis. This is the error of each step, for any heading.
TEST(RelativePoseError, IsDriftPerFrame) {
  const double turn_rad = 2 * std::acos(-1) / 180;
  const Rigid3d step(QuaternionExp<double>({0, 0, turn_rad}), {0.1, 0, 0});
  std::vector<MatchedPose> poses(100);
  for (std::size_t i = 1; i < poses.size(); ++i) poses[i].estimate = poses[i - 1].estimate * step;
  const auto rpe = ComputeRelativePoseError(poses, {});
  EXPECT_NEAR(rpe->translation_m.rmse, 0.1, 1e-12);
  EXPECT_NEAR(rpe->rotation_deg.rmse, 2, 1e-10);
  EXPECT_NEAR(rpe->rotation_deg.max, 2, 1e-10);
}

// Q_i^-1 Q_j is a rotation of 90 degrees about z and 1 m along x. P_i^-1 P_j is 1 m along x without
// rotation. E = (Rz90, (1,0,0))^-1 (I, (1,0,0)) = (Rz-90, 0): the translations cancel in the frame
// of i.
TEST(RelativePoseError, ComparesMotionsInFrameOfFirstPose) {
  std::vector<MatchedPose> poses(2);
  const double quarter_rad = std::acos(-1) / 2;
  poses[1].ground_truth = Rigid3d(QuaternionExp<double>({0, 0, quarter_rad}), {1, 0, 0});
  poses[1].estimate.translation = {1, 0, 0};
  const auto rpe = ComputeRelativePoseError(poses, {});
  EXPECT_NEAR(rpe->translation_m.max, 0, 1e-12);
  EXPECT_NEAR(rpe->rotation_deg.max, 90, 1e-10);
}

TEST(RelativePoseError, IsIndependentOfWorldFrames) {
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

// Timestamps 0, 1, 2, 5 with h = 0.3 at the third pose. Only poses 0 and 1 have a pose one second
// later. For pose 2, the nearest pose has a deviation of more than a tenth of a second.
TEST(RelativePoseError, SupportsStepInSeconds) {
  auto poses = SquareWithALiftedCorner(0.3);
  poses[3].stamp_s = 5;
  const auto rpe = ComputeRelativePoseError(poses, {1, Unit::kSeconds});
  EXPECT_EQ(rpe->translation_m.count, 2u);
  EXPECT_NEAR(rpe->translation_m.rmse, 0.3 * std::sqrt(1. / 2), 1e-12);
  // 2.05 s: only 0 -> 2, with a deviation of 0.05 s. The limit is 0.205 s.
  EXPECT_EQ(ComputeRelativePoseError(poses, {2.05, Unit::kSeconds})->translation_m.count, 1u);
}

TEST(RelativePoseError, IsNulloptWithoutPairs) {
  const auto poses = SquareWithALiftedCorner(0.3);
  EXPECT_FALSE(ComputeRelativePoseError({}, {}).has_value());
  EXPECT_FALSE(ComputeRelativePoseError(poses, {4, Unit::kFrames}).has_value());
  EXPECT_FALSE(ComputeRelativePoseError(poses, {0.5, Unit::kSeconds}).has_value());
}

TEST(RelativePoseErrorOptions, ValidateRejectsInvalidValues) {
  EXPECT_NO_THROW((Validate(RelativePoseErrorOptions{0.5, Unit::kSeconds})));
  EXPECT_THROW((Validate(RelativePoseErrorOptions{0.5, Unit::kFrames})), InputError);
  EXPECT_THROW((Validate(RelativePoseErrorOptions{0, Unit::kFrames})), InputError);
  EXPECT_THROW((Validate(RelativePoseErrorOptions{-1, Unit::kSeconds})), InputError);
  EXPECT_THROW((Validate(RelativePoseErrorOptions{std::nan(""), Unit::kSeconds})), InputError);
}

// `count` poses along a curve, at `rate` Hz.
Trajectory Curve(int count, double rate) {
  Trajectory trajectory;
  for (int i = 0; i < count; ++i) {
    const double t = i / rate;
    trajectory.push_back({t, Rigid3d(Eigen::Quaterniond::Identity(), {t, t * t, 0})});
  }
  return trajectory;
}

TEST(EvaluateTrajectory, IsZeroWithFullCoverageForGroundTruth) {
  const Trajectory t = Curve(10, 30);
  const auto evaluation = EvaluateTrajectory(t, t, Stamps(t), {});
  EXPECT_EQ(evaluation.expected, 10);
  EXPECT_EQ(evaluation.matched, 10);
  EXPECT_EQ(evaluation.coverage, 1);
  EXPECT_LT(evaluation.ate->translation_m.max, 1e-12);
  EXPECT_LT(evaluation.rpe->translation_m.max, 1e-12);
}

TEST(EvaluateTrajectory, CoverageCountsFramesWithGroundTruth) {
  // Ground truth at 90 Hz covers the first 8 of 10 frames at 30 Hz. Two of these are lost. The last
  // two frames are neither expected nor matched.
  const Trajectory ground_truth = Curve(3 * 7 + 1, 90);
  const Trajectory frames = Curve(10, 30);
  Trajectory estimate = frames;
  estimate.erase(estimate.begin() + 4, estimate.begin() + 6);
  const auto evaluation = EvaluateTrajectory(ground_truth, estimate, Stamps(frames), {});
  EXPECT_EQ(evaluation.expected, 8);
  EXPECT_EQ(evaluation.matched, 6);
  EXPECT_DOUBLE_EQ(evaluation.coverage, 6. / 8);
}

TEST(EvaluateTrajectory, IsZeroForConstantMotionBetweenTimestamps) {
  const Trajectory estimate = Steady(20, 1 / 30., 0.1 + 0.0041);
  const auto evaluation = EvaluateTrajectory(Steady(120, 0.01, 0), estimate, Stamps(estimate), {});
  EXPECT_EQ(evaluation.matched, 20);
  EXPECT_EQ(evaluation.coverage, 1);
  EXPECT_LT(evaluation.ate->translation_m.max, 1e-12);
  EXPECT_LT(evaluation.rpe->translation_m.max, 1e-12);
  // The nearest pose is up to 5 ms away, at 0.6 m/s.
  TrajectoryEvaluationOptions nearest;
  nearest.match.max_gap_s = 0;
  EXPECT_GT(EvaluateTrajectory(Steady(120, 0.01, 0), estimate, Stamps(estimate), nearest)
                .ate->translation_m.rmse,
            1e-3);
}

TEST(EvaluateTrajectory, HasNoErrorsWithoutPoses) {
  const Trajectory t = Curve(10, 30);
  const auto lost = EvaluateTrajectory(t, {}, Stamps(t), {});
  EXPECT_EQ(lost.coverage, 0);
  EXPECT_FALSE(lost.ate.has_value());
  EXPECT_FALSE(lost.rpe.has_value());
  EXPECT_EQ(EvaluateTrajectory({}, t, Stamps(t), {}).coverage, 0);
}

}  // namespace
}  // namespace surfit::testing
