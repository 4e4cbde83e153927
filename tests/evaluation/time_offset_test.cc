#include <gmock/gmock.h>

#include <cmath>

#include "surfit/evaluation/trajectory_evaluation.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

// Trajectory of a swinging camera: a rigid transform cannot compensate a time offset.
Trajectory Swing(int count, double period_s, double begin_s) {
  Trajectory trajectory;
  for (int i = 0; i < count; ++i) {
    const double t = begin_s + i * period_s;
    trajectory.push_back({t, Rigid3d(Eigen::Quaterniond::Identity(),
                                     {0.3 * std::sin(3 * t), 0.2 * std::sin(5 * t), 0.1 * t})});
  }
  return trajectory;
}

// Interpolation error between poses at 10 ms: a dt^2 / 8 with a = 0.2 * 5^2, 0.06 mm.
constexpr double kInterpolation_m = 1e-4;

TEST(TimeOffset, RecoversTimestampDelay) {
  const Trajectory truth = Swing(301, 0.01, 0);
  for (const double late_s : {0.0213, -0.0358, 0.0071}) {
    const Trajectory estimate = WithTimeOffset(Swing(75, 1 / 30., 0.25), late_s);
    const double plain_m = EvaluateTimeOffset(truth, estimate, 0, {})->ate.translation_m.rmse;
    const auto found = EstimateTimeOffset(truth, estimate, {});
    ASSERT_TRUE(found);
    // 0.1 mm is 0.15 ms at about 0.7 m/s.
    EXPECT_NEAR(found->offset_s, -late_s, 2e-4);
    EXPECT_LT(found->ate.translation_m.rmse, kInterpolation_m);
    EXPECT_GT(plain_m, 10 * kInterpolation_m);
    EXPECT_EQ(EvaluateTimeOffset(truth, estimate, found->offset_s, {})->ate.translation_m.rmse,
              found->ate.translation_m.rmse);
  }
}

TEST(TimeOffset, IsZeroForGroundTruth) {
  const Trajectory truth = Swing(61, 1 / 30., 0);
  const auto found = EstimateTimeOffset(truth, truth, {});
  ASSERT_TRUE(found);
  EXPECT_EQ(found->offset_s, 0);
  EXPECT_LT(found->ate.translation_m.max, 1e-12);
}

TEST(TimeOffset, IsLimitedToTenthOfSecond) {
  const Trajectory estimate = WithTimeOffset(Swing(75, 1 / 30., 0.25), 0.17);
  EXPECT_NEAR(EstimateTimeOffset(Swing(401, 0.01, 0), estimate, {})->offset_s, -0.1, 1e-5);
}

TEST(TimeOffset, IsNulloptWithoutThreeMatchedPoses) {
  const Trajectory truth = Swing(301, 0.01, 0);
  EXPECT_FALSE(EstimateTimeOffset(truth, Swing(2, 0.1, 1), {}));
  EXPECT_FALSE(EstimateTimeOffset(truth, Swing(5, 0.01, 0.01), {}));
  EXPECT_FALSE(EstimateTimeOffset({}, Swing(5, 0.1, 1), {}));
  EXPECT_FALSE(EvaluateTimeOffset(truth, Swing(5, 0.1, 1), 100, {}));
}

TEST(TimeOffset, RejectsInvalidOptionsWithoutPoses) {
  MatchOptions options;
  options.max_gap_s = -1;
  ExpectInputError([&] { EstimateTimeOffset({}, {}, options); }, HasSubstr("max_gap_s is -1"));
}

}  // namespace
}  // namespace surfit::testing
