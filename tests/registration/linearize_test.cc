#include <gtest/gtest.h>

#include "registration/simulated_views.h"
#include "surfit/core/parallel.h"
#include "surfit/registration/projective_association.h"
#include "testing/matchers.h"

namespace surfit {
namespace {

using testing::VectorNear;

class Linearize : public ::testing::Test {
 protected:
  const testing::SimulatedViews views_ = testing::MakeViews(0, 5);
  const ProjectiveAssociation association_{views_.source.levels[0], views_.target.levels[0],
                                           AssociationGates(), ErrorModel()};
};

// The fused pass takes the same pairs. A product of a weight and two columns has about 12 roundings
// of float, 8 values a lane are summed in float: 20 * 2^-24 of the sums of absolute values.
TEST_F(Linearize, SumsWhatCollectLists) {
  constexpr double kRelative = 20.0 / (1 << 24);
  for (const Rigid3d& pose : {Rigid3d(), views_.target_from_source}) {
    const Correspondences pairs = association_.Collect(pose);
    ASSERT_GT(pairs.size(), 5000u);
    const NormalSystem expected = BuildNormalSystem(pairs), actual = association_.Linearize(pose);
    EXPECT_EQ(actual.pair_count, expected.pair_count);
    EXPECT_EQ(actual.inlier_count, expected.inlier_count);
    EXPECT_NEAR(actual.weight_sum, expected.weight_sum, kRelative * expected.weight_sum);
    EXPECT_NEAR(actual.weighted_point_square_sum, expected.weighted_point_square_sum,
                kRelative * expected.weighted_point_square_sum);
    EXPECT_NEAR(actual.weighted_square_sum, expected.weighted_square_sum,
                // b = n . (q - p') itself is off by 5 roundings of 8 m: 2.4e-6 m.
                kRelative * expected.weighted_square_sum +
                    2 * 2.4e-6 * std::sqrt(expected.weighted_square_sum * expected.weight_sum));
    // Columns are at most |p'| < 9 m long, those of p' x n differences of such products.
    const double size = expected.weighted_point_square_sum + expected.weight_sum;
    EXPECT_THAT(actual.hessian, VectorNear(expected.hessian, 6 * kRelative * size));
    const double right_size = std::sqrt(size * expected.weighted_square_sum) +
                              2.4e-6 / kRelative * std::sqrt(size * expected.weight_sum);
    EXPECT_THAT(actual.right_side, VectorNear(expected.right_side, 6 * kRelative * right_size));
    EXPECT_TRUE(actual.hessian == actual.hessian.transpose());
  }
}

TEST_F(Linearize, IsTheSameAtAnyNumberOfThreads) {
  const auto linearize = [&](int threads) {
    const ThreadLimit limit(threads);
    return association_.Linearize(views_.target_from_source);
  };
  const NormalSystem expected = linearize(1);
  for (const int threads : {2, 4}) {
    const NormalSystem actual = linearize(threads);
    EXPECT_TRUE(actual.hessian == expected.hessian);
    EXPECT_TRUE(actual.right_side == expected.right_side);
    EXPECT_EQ(actual.weighted_square_sum, expected.weighted_square_sum);
    EXPECT_EQ(actual.weight_sum, expected.weight_sum);
    EXPECT_EQ(actual.inlier_count, expected.inlier_count);
  }
}

}  // namespace
}  // namespace surfit
