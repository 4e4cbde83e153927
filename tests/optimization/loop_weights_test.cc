#include "optimization/loop_weights.h"

#include <gmock/gmock.h>

#include "surfit/optimization/optimize_pose_graph.h"

namespace surfit {
namespace {

TEST(LoopWeights, ThresholdIsAChiSquareQuantile) {
  // 6 degrees of freedom: P(x) = 1 - exp(-x/2) (1 + x/2 + x^2/8).
  const double half = PoseGraphOptions().max_loop_squared_error / 2;
  EXPECT_NEAR(1 - std::exp(-half) * (1 + half + half * half / 2), 0.999, 1e-8);
}

TEST(LoopWeights, LeaveAllAloneWhereAllFit) {
  LoopWeights weights(10, {1, 9.9, 0});
  EXPECT_TRUE(weights.AllFit());
  EXPECT_THAT(weights.Update({1, 9.9, 0}), testing::Each(1));
}

// With errors that stay, mu goes to infinity and the weights to [e^2 < c^2].
TEST(LoopWeights, EndAtTheTruncation) {
  const std::vector<double> errors = {0, 5, 9, 11, 20, 1e6};
  LoopWeights weights(10, errors);
  std::vector<double> w = weights.Update(errors);
  EXPECT_FALSE(AreBinary(w));
  for (int i = 0; i < 100; ++i) w = weights.Update(errors);
  EXPECT_THAT(w, testing::ElementsAre(1, 1, 1, 0, 0, 0));
  EXPECT_TRUE(AreBinary(w));
}

// The weight is what minimises w e^2 + mu (1 - w) / (mu + w) c^2, eq. 7 of the paper.
TEST(LoopWeights, MinimiseTheSurrogate) {
  const double limit = 10, largest = 30, mu = limit / (2 * largest - limit);
  for (double error = 1; error < 60; error += 2) {
    LoopWeights weights(limit, {largest});
    const double w = weights.Update({error})[0];
    const auto cost = [&](double x) { return x * error + mu * (1 - x) / (mu + x) * limit; };
    for (double x = 0; x <= 1; x += 0.01) {
      EXPECT_LE(cost(w), cost(x) + 1e-9) << error << " " << x;
    }
  }
}

}  // namespace
}  // namespace surfit
