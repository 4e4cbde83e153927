#include <gtest/gtest.h>

#include "registration/dual_system.h"
#include "registration/icp/icp_level.h"
#include "registration/random_correspondences.h"
#include "registration/simulated_views.h"
#include "surfit/registration/association.h"
#include "testing/matchers.h"
#include "testing/threads.h"

namespace surfit::testing {
namespace {

constexpr ResidualType kResiduals[] = {ResidualType::kPointToPoint, ResidualType::kPointToPlane,
                                       ResidualType::kSymmetricPointToPlane,
                                       ResidualType::kPlaneToPlane};
constexpr RobustKernelType kKernels[] = {RobustKernelType::kNone, RobustKernelType::kHuber,
                                         RobustKernelType::kTukey, RobustKernelType::kGemanMcClure,
                                         RobustKernelType::kStudentT};

// Expects sums within `relative` of the expected sums, relative to sums of absolute values.
void ExpectNear(const NormalSystem& actual, const NormalSystem& expected, double relative) {
  const Vector6d root = expected.hessian.diagonal().cwiseSqrt();
  const double residual_root = std::sqrt(expected.weighted_square_sum);
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) {
      // Cauchy-Schwarz: sum |w a_i a_j| <= root_i root_j.
      EXPECT_NEAR(actual.hessian(i, j), expected.hessian(i, j), relative * root[i] * root[j]);
    }
    EXPECT_NEAR(actual.right_side[i], expected.right_side[i], relative * root[i] * residual_root);
  }
  const auto expect = [&](double a, double b) { EXPECT_NEAR(a, b, relative * b); };
  expect(actual.cost, expected.cost);
  expect(actual.weighted_square_sum, expected.weighted_square_sum);
  expect(actual.weight_sum, expected.weight_sum);
  expect(actual.normal_difference_sum, expected.normal_difference_sum);
  const double square = expected.point_product_sum.trace();
  EXPECT_THAT(actual.point_sum,
              VectorNear(expected.point_sum, relative * std::sqrt(square * expected.weight_sum)));
  EXPECT_THAT(actual.point_product_sum, VectorNear(expected.point_product_sum, relative * square));
  EXPECT_EQ(actual.row_count, expected.row_count);
  EXPECT_EQ(actual.pair_count, expected.pair_count);
}

class LinearizeResidual : public ::testing::TestWithParam<ResidualType> {};

// In double precision, the closed-form rows agree with autodiff of the definition. Rounding is
// 1e-16 of values of the same size. The covariance of a plane has the condition number 1e3, so its
// inverse and factor lose three digits.
TEST_P(LinearizeResidual, RowsAgreeWithAutodiff) {
  std::mt19937_64 rng(1);
  for (const RobustKernelType kernel : kKernels) {
    const Correspondences pairs = RandomCorrespondences(1000, 1, &rng);
    const RobustKernel robust = {kernel, 0.7};
    const NormalSystem actual = Linearize(pairs, GetParam(), robust);
    const NormalSystem expected = DualSystem(pairs, GetParam(), robust);
    ExpectNear(actual, expected, 1e-11);
    EXPECT_EQ(actual.inlier_count, expected.inlier_count);
  }
}

// Single-precision lanes compared with double precision. A product of a weight and two columns has
// about 20 roundings, and a lane sums 8 products. Columns p x n of points at 4.6 m are differences
// of products that are up to 5 times larger.
constexpr double kSinglePrecision = 5.0 * 30 / (1 << 24);

TEST_P(LinearizeResidual, SinglePrecisionAgreesForAnyCount) {
  std::mt19937_64 rng(2);
  // The whitening of planes in float inverts a matrix with condition number 1e3 by cofactors.
  const double relative =
      GetParam() == ResidualType::kPlaneToPlane ? 100 * kSinglePrecision : kSinglePrecision;
  for (const int count : {0, 63, 64, 65, 5000}) {
    const PairBuffer pairs = Rounded<float>(RandomCorrespondences(count, 1, &rng));
    const RobustKernel kernel = {RobustKernelType::kGemanMcClure, 3};
    ExpectNear(Linearize(pairs, GetParam(), kernel),
               DualSystem(AsDouble(pairs), GetParam(), kernel), relative);
  }
}

TEST_P(LinearizeResidual, BesidesProductsContainsRemainingSums) {
  std::mt19937_64 rng(4);
  const Correspondences pairs = RandomCorrespondences(1000, 0.1, &rng);
  const RobustKernel kernel = {RobustKernelType::kHuber, 0.7};
  NormalSystem rest = LinearizeWithoutProducts(pairs, GetParam(), kernel);
  const NormalSystem whole = Linearize(pairs, GetParam(), kernel);
  EXPECT_TRUE(rest.hessian.isZero(0));
  EXPECT_TRUE(rest.right_side.isZero(0));
  EXPECT_EQ(rest.cost, 0);
  EXPECT_EQ(rest.weighted_square_sum, 0);
  EXPECT_EQ(rest.inlier_count, whole.inlier_count);
  EXPECT_EQ(rest.normal_ratio, whole.normal_ratio);
  rest.hessian = whole.hessian;
  rest.right_side = whole.right_side;
  rest.cost = whole.cost;
  rest.weighted_square_sum = whole.weighted_square_sum;
  ExpectNear(rest, whole, 1e-14);
}

TEST_P(LinearizeResidual, IgnoresValuesBeyondSize) {
  std::mt19937_64 rng(3);
  const Correspondences pairs = RandomCorrespondences(9, 0.1, &rng);
  Correspondences longer = pairs;
  longer.SetCapacity(64);
  for (auto* array : longer.Arrays()) std::fill(array->begin() + 9, array->end(), NAN);
  const NormalSystem expected = Linearize(pairs, GetParam(), {}),
                     actual = Linearize(longer, GetParam(), {});
  EXPECT_TRUE(actual.hessian == expected.hessian);
  EXPECT_EQ(actual.inlier_count, expected.inlier_count);
}

INSTANTIATE_TEST_SUITE_P(Residuals, LinearizeResidual, ::testing::ValuesIn(kResiduals),
                         [](const auto& instance) { return ToString(instance.param); });

TEST(Linearize, IsZeroWithoutPairs) {
  const NormalSystem system = Linearize(Correspondences(), ResidualType::kPointToPlane, {});
  EXPECT_EQ(system.pair_count, 0);
  EXPECT_EQ(system.RmsDistance(), 0);
  EXPECT_TRUE(system.hessian.isZero(0));
  EXPECT_EQ(system.AverageLoss(), 0);
}

TEST(Linearize, CountsPairsWithinThreeSigmasAsInliers) {
  Correspondences pairs;
  const double sigma_m = 0.01;
  for (const double height_m : {0.0, 0.0299, -0.0299, 0.0301, -0.0301}) {
    pairs.Add({0.3, 0, 2 + height_m}, {0, 0, 2}, {0, 0, -1}, {0, 0, -1}, 1 / (sigma_m * sigma_m));
  }
  EXPECT_EQ(Linearize(pairs, ResidualType::kPointToPlane, {}).inlier_count, 3);
  EXPECT_EQ(Linearize(pairs, ResidualType::kPointToPoint, {}).inlier_count, 0);
}

class LinearizeAssociation : public ::testing::Test {
 protected:
  const SimulatedViews views_ = MakeViews(0, 5);
  const ErrorModel error_model_;
  const ProjectiveAssociation association_{views_.source.levels[0], views_.target.levels[0],
                                           AssociationGates(), error_model_, NeededNormals::kBoth};
};

// The pass without a list uses the same correspondences and sums them in other groups.
TEST_F(LinearizeAssociation, AgreesWithCollectedList) {
  for (const Rigid3d& pose : {Rigid3d(), views_.target_from_source}) {
    const PairBuffer pairs = association_.Collect(pose);
    ASSERT_GT(pairs.size, 5000);
    for (const ResidualType type : kResiduals) {
      const NormalSystem expected = Linearize(pairs, type, error_model_.kernel);
      const NormalSystem actual = Linearize(association_, pose, type, error_model_.kernel);
      ExpectNear(actual, expected, kSinglePrecision);
      EXPECT_EQ(actual.inlier_count, expected.inlier_count);
      EXPECT_TRUE(actual.hessian == actual.hessian.transpose());
    }
  }
}

TEST_F(LinearizeAssociation, IsTheSameAtAnyNumberOfThreads) {
  const auto systems = AtThreads({1, 2, 4}, [&] {
    return Linearize(association_, views_.target_from_source, ResidualType::kPointToPlane,
                     error_model_.kernel);
  });
  const NormalSystem& expected = systems[0];
  for (const NormalSystem& actual : systems) {
    EXPECT_TRUE(actual.hessian == expected.hessian);
    EXPECT_TRUE(actual.right_side == expected.right_side);
    EXPECT_EQ(actual.weighted_square_sum, expected.weighted_square_sum);
    EXPECT_EQ(actual.weight_sum, expected.weight_sum);
    EXPECT_EQ(actual.inlier_count, expected.inlier_count);
  }
}

}  // namespace
}  // namespace surfit::testing
