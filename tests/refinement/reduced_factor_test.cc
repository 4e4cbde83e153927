// The factor by blocks against dense solutions of the whole system.
#include "refinement/reduced_factor.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "refinement/dense_hessian.h"
#include "refinement/joint_covariance.h"
#include "refinement/random_surfels.h"

namespace surfit {
namespace {

using testing::DenseHessian;
using testing::MakeRandomProblem;
using testing::RandomProblem;

constexpr int kPoses = 40, kSurfels = 2000;
constexpr double kDamping = 1e-4;
// Scaled to a diagonal of ones the condition is below 1 / kDamping, or 1e6 without damping; sums of
// some hundreds of products.
constexpr double kPrecision = 1e-9;

// With poses far along a corridor, or all before the same wall.
struct View {
  int reach;
  bool dense;
};

class ReducedFactorOfView : public ::testing::TestWithParam<View> {
 protected:
  ReducedFactorOfView() {
    held_[1] = held_[7] = true;
    for (int i = 0; i < kCalibrationSize; ++i) {
      if (!held_[i]) free_.push_back(kPoseTangentSize * kPoses + i);
    }
    for (int i = kPoseTangentSize * kPoses - 1; i >= kPoseTangentSize; --i) {
      free_.insert(free_.begin(), i);
    }
  }

  const RandomProblem problem_ = MakeRandomProblem(kPoses, kSurfels, 1, GetParam().reach);
  const BlockPattern pattern_ = {problem_.shared, kPoses};
  const ReducedSystem system_ = Reduce(problem_.shared, pattern_, problem_.state, {});
  const Eigen::MatrixXd hessian_ = DenseHessian(system_);
  std::vector<bool> held_ = std::vector<bool>(kCalibrationSize, false);
  std::vector<Eigen::Index> free_;
};

TEST_P(ReducedFactorOfView, IsOfTheFasterKind) {
  EXPECT_EQ(PoseFactor(pattern_).is_dense(), GetParam().dense);
}

TEST_P(ReducedFactorOfView, SolvesForTheDampedStep) {
  ReducedFactor factor(pattern_, held_);
  ASSERT_TRUE(factor.Factorize(system_, kDamping));
  const ReducedStep step = factor.Solve(system_.gradient);

  const Eigen::MatrixXd free = hessian_(free_, free_);
  Eigen::MatrixXd damped = free;
  damped.diagonal() *= 1 + kDamping;
  const Eigen::VectorXd gradient = system_.gradient(free_);
  const Eigen::VectorXd expected = -damped.partialPivLu().solve(gradient);
  Eigen::VectorXd embedded = Eigen::VectorXd::Zero(hessian_.rows());
  embedded(free_) = expected;
  const Eigen::VectorXd root = hessian_.diagonal().cwiseSqrt();
  EXPECT_LT((step.increments - embedded).cwiseProduct(root).norm(),
            kPrecision * embedded.cwiseProduct(root).norm());
  const double model = -2 * gradient.dot(expected) - expected.dot(free * expected);
  EXPECT_NEAR(step.rho_decrease, model, kPrecision * model);
}

TEST_P(ReducedFactorOfView, HasTheBlocksOfTheInverse) {
  const JointCovariance covariance = CovarianceOf(system_, held_);
  Eigen::MatrixXd inverse = Eigen::MatrixXd::Zero(hessian_.rows(), hessian_.cols());
  const Eigen::MatrixXd free = hessian_(free_, free_);
  inverse(free_, free_) = Eigen::MatrixXd(free.inverse());
  const auto difference = [&](const Eigen::MatrixXd& ours, Eigen::Index begin) {
    const Eigen::MatrixXd block = inverse.block(begin, begin, ours.rows(), ours.cols());
    const Eigen::VectorXd scale =
        block.diagonal().unaryExpr([](double d) { return d > 0 ? 1 / std::sqrt(d) : 1.; });
    return (scale.asDiagonal() * (ours - block) * scale.asDiagonal()).cwiseAbs().maxCoeff();
  };
  constexpr double kOfInverse = 1e-6;  // pivots of 1e-12, and a condition below 1e6
  EXPECT_LT(difference(covariance.calibration, kPoseTangentSize * kPoses), kOfInverse);
  ASSERT_EQ(covariance.poses.size(), std::size_t{kPoses});
  for (int k = 0; k < kPoses; ++k) {
    EXPECT_LT(difference(covariance.poses[k], kPoseTangentSize * k), kOfInverse) << k;
  }
}

INSTANTIATE_TEST_SUITE_P(Views, ReducedFactorOfView,
                         ::testing::Values(View{1, false}, View{kPoses, true}));

TEST(ReducedFactor, LeavesAPoseThatSeesNothingWhereItIs) {
  RandomProblem problem = MakeRandomProblem(5, 200, 1);
  problem.state.world_from_camera.push_back(problem.state.world_from_camera.back());
  const BlockPattern pattern(problem.shared, 6);
  const ReducedSystem system = Reduce(problem.shared, pattern, problem.state, {});
  const std::vector<bool> held(kCalibrationSize, true);
  ReducedFactor factor(pattern, held);
  ASSERT_TRUE(factor.Factorize(system, kDamping));
  const ReducedStep step = factor.Solve(system.gradient);
  EXPECT_GT(step.increments.segment<kPoseTangentSize>(24).norm(), 0);
  EXPECT_EQ(step.increments.tail(kPoseTangentSize + kCalibrationSize).norm(), 0);
  const JointCovariance covariance = CovarianceOf(system, held);
  EXPECT_EQ(covariance.poses[0].norm(), 0);
  EXPECT_TRUE(covariance.poses[4].allFinite());
  EXPECT_TRUE(covariance.poses[5].diagonal().array().isInf().all());
}

}  // namespace
}  // namespace surfit
