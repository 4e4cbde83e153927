#include "surfit/evaluation/trajectory_evaluation.h"

#include <gtest/gtest.h>

namespace surfit {
namespace {

// `count` poses along a curve, `rate` a second.
Trajectory Curve(int count, double rate) {
  Trajectory trajectory;
  for (int i = 0; i < count; ++i) {
    const double t = i / rate;
    trajectory.push_back({t, Rigid3d(Eigen::Quaterniond::Identity(), {t, t * t, 0})});
  }
  return trajectory;
}

TEST(EvaluateTrajectory, OfTheTruthIsZeroWithFullCoverage) {
  const Trajectory t = Curve(10, 30);
  const auto evaluation = EvaluateTrajectory(t, t, Stamps(t), {});
  EXPECT_EQ(evaluation.expected, 10);
  EXPECT_EQ(evaluation.matched, 10);
  EXPECT_EQ(evaluation.coverage, 1);
  EXPECT_LT(evaluation.ate->translation_m.max, 1e-12);
  EXPECT_LT(evaluation.rpe->translation_m.max, 1e-12);
}

TEST(EvaluateTrajectory, CoverageCountsTheFramesThatTheGroundTruthKnows) {
  // Motion capture at 90 Hz for the first 8 of 10 frames at 30 Hz; 2 of these 8 are lost, and the
  // 2 later ones are neither expected nor matched.
  const Trajectory ground_truth = Curve(3 * 7 + 1, 90);
  const Trajectory frames = Curve(10, 30);
  Trajectory estimate = frames;
  estimate.erase(estimate.begin() + 4, estimate.begin() + 6);
  const auto evaluation = EvaluateTrajectory(ground_truth, estimate, Stamps(frames), {});
  EXPECT_EQ(evaluation.expected, 8);
  EXPECT_EQ(evaluation.matched, 6);
  EXPECT_DOUBLE_EQ(evaluation.coverage, 6. / 8);
}

TEST(EvaluateTrajectory, WithoutPosesSaysSo) {
  const Trajectory t = Curve(10, 30);
  const auto lost = EvaluateTrajectory(t, {}, Stamps(t), {});
  EXPECT_EQ(lost.coverage, 0);
  EXPECT_FALSE(lost.ate.has_value());
  EXPECT_FALSE(lost.rpe.has_value());
  EXPECT_EQ(EvaluateTrajectory({}, t, Stamps(t), {}).coverage, 0);
}

}  // namespace
}  // namespace surfit
