#include "cost_functions/analytic_relative_pose.h"

#include <ceres/autodiff_cost_function.h>
#include <gtest/gtest.h>

#include "cost_functions/pose_manifold.h"
#include "cost_functions/relative_pose.h"
#include "cost_functions/solve_pose.h"
#include "testing/random_pose.h"

namespace surfit {
namespace {

using testing::AsBlock;
using testing::RandomPose;

using Residuals = Eigen::Matrix<double, 6, 1>;
using Ambient = Eigen::Matrix<double, 6, kPoseSize, Eigen::RowMajor>;
using Tangent = Eigen::Matrix<double, kPoseSize, kPoseTangentSize, Eigen::RowMajor>;

struct Evaluation {
  Residuals residuals;
  Eigen::Matrix<double, 6, kPoseTangentSize> by_a, by_b;  // along the manifold
};

Evaluation Evaluate(const ceres::CostFunction& cost, const Rigid3d& a, const Rigid3d& b) {
  const auto block_a = AsBlock(a), block_b = AsBlock(b);
  const double* blocks[] = {block_a.data(), block_b.data()};
  Ambient by_a, by_b;
  double* jacobians[] = {by_a.data(), by_b.data()};
  Evaluation e;
  cost.Evaluate(blocks, e.residuals.data(), jacobians);
  Tangent plus_a, plus_b;
  ProductPoseManifold().PlusJacobian(block_a.data(), plus_a.data());
  ProductPoseManifold().PlusJacobian(block_b.data(), plus_b.data());
  e.by_a = by_a * plus_a;
  e.by_b = by_b * plus_b;
  return e;
}

// At errors of the given size in rad and m.
void ExpectAutodiffAgrees(double size, std::mt19937_64* rng) {
  const Rigid3d a = RandomPose(1, 5, rng), a_from_b = RandomPose(1, 2, rng);
  const Rigid3d b = a * RandomPose(size, size, rng) * a_from_b;
  PoseInformation root;
  for (int i = 0; i < 6; ++i)
    root.row(i) << testing::RandomVector(3, rng).transpose(),
        testing::RandomVector(3, rng).transpose();
  const PoseInformation information = root * root.transpose() + PoseInformation::Identity();
  const ceres::AutoDiffCostFunction<RelativePose, 6, kPoseSize, kPoseSize> autodiff(
      new RelativePose(a_from_b, information));
  const Evaluation expected = Evaluate(autodiff, a, b);
  const Evaluation found = Evaluate(AnalyticRelativePose(a_from_b, information), a, b);
  const double scale = expected.by_a.norm() + expected.by_b.norm();
  EXPECT_LT((found.residuals - expected.residuals).norm(), 1e-12 * scale) << size;
  EXPECT_LT((found.by_a - expected.by_a).norm(), 1e-10 * scale) << size;
  EXPECT_LT((found.by_b - expected.by_b).norm(), 1e-10 * scale) << size;
}

// 1e-2 and 1e-3 are on both sides of where the series of InverseLeftJacobian() begins; 1.7 in each
// component reaches almost pi.
TEST(AnalyticRelativePose, AgreesWithAutodiff) {
  std::mt19937_64 rng(5);
  for (const double size : {0., 1e-8, 1e-3, 0.0057, 1e-2, 0.1, 1., 1.7}) {
    for (int trial = 0; trial < 20; ++trial) ExpectAutodiffAgrees(size, &rng);
  }
}

}  // namespace
}  // namespace surfit
