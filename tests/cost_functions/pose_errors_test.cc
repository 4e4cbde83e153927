#include <ceres/autodiff_cost_function.h>
#include <gtest/gtest.h>

#include "cost_functions/analytic_relative_pose.h"
#include "cost_functions/pose_manifold.h"
#include "cost_functions/pose_prior.h"
#include "cost_functions/random_functors.h"
#include "cost_functions/relative_pose.h"
#include "testing/matchers.h"
#include "testing/random_pose.h"

namespace surfit::testing {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;

// Dense information matrix with large off-diagonal values.
PoseInformation RandomInformation(std::mt19937_64* rng) {
  PoseInformation root;
  for (int i = 0; i < 6; ++i) root.col(i) << RandomVector(10, rng), RandomVector(10, rng);
  return root * root.transpose() + PoseInformation::Identity();
}

Vector6 RandomIncrement(std::mt19937_64* rng) {
  Vector6 delta;
  delta << RandomVector(0.5, rng), RandomVector(1, rng);
  return delta;
}

TEST(PosePrior, CostIsMahalanobisDistanceOfIncrement) {
  std::mt19937_64 rng(1);
  for (int trial = 0; trial < 50; ++trial) {
    const Rigid3d prior = RandomPose(1, 3, &rng);
    const PoseInformation information = RandomInformation(&rng);
    const Vector6 delta = RandomIncrement(&rng);
    Vector6 residuals;
    PosePrior(prior, information)(AsBlock(LeftIncrement<double>(delta, prior)).data(),
                                  residuals.data());
    const double expected = delta.dot(information * delta);
    EXPECT_NEAR(residuals.squaredNorm(), expected, 1e-11 * expected);
  }
}

TEST(RelativePose, CostIsMahalanobisDistanceOfIncrement) {
  std::mt19937_64 rng(2);
  for (int trial = 0; trial < 50; ++trial) {
    const Rigid3d a_from_b = RandomPose(1, 3, &rng), world_from_a = RandomPose(1, 3, &rng);
    const PoseInformation information = RandomInformation(&rng);
    const Vector6 delta = RandomIncrement(&rng);
    const Rigid3d world_from_b = world_from_a * LeftIncrement<double>(delta, a_from_b);
    Vector6 residuals;
    RelativePose(a_from_b, information)(AsBlock(world_from_a).data(), AsBlock(world_from_b).data(),
                                        residuals.data());
    const double expected = delta.dot(information * delta);
    EXPECT_NEAR(residuals.squaredNorm(), expected, 1e-11 * expected);
  }
}

// A prior and a chain of exact relative poses constrain all poses.
TEST(RelativePose, ChainOfPosesFollowsPrior) {
  std::mt19937_64 rng(3);
  std::vector<Rigid3d> truth;
  std::vector<PoseBlock> poses;
  ceres::Problem problem;
  for (int i = 0; i < 5; ++i) {
    truth.push_back(RandomPose(1, 3, &rng));
    poses.push_back(AsBlock(RandomPose(0.3, 1, &rng) * truth.back()));
  }
  for (auto& pose : poses) {
    problem.AddParameterBlock(pose.data(), kPoseSize, new LeftPoseManifold);
  }
  problem.AddResidualBlock(new ceres::AutoDiffCostFunction<PosePrior, 6, kPoseSize>(
                               new PosePrior(truth[0], RandomInformation(&rng))),
                           nullptr, poses[0].data());
  for (int i = 1; i < 5; ++i) {
    const Rigid3d a_from_b = truth[i - 1].Inverse() * truth[i];
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<RelativePose, 6, kPoseSize, kPoseSize>(
                                 new RelativePose(a_from_b, RandomInformation(&rng))),
                             nullptr, poses[i - 1].data(), poses[i].data());
  }
  Solve(&problem);
  for (int i = 0; i < 5; ++i) {
    EXPECT_THAT(PoseFromBlock(poses[i].data()), RigidNear(truth[i], 1e-9, 1e-9)) << i;
  }
}

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

void ExpectAutodiffAgrees(double size, std::mt19937_64* rng) {
  const Rigid3d a = RandomPose(1, 5, rng), a_from_b = RandomPose(1, 2, rng);
  const Rigid3d b = a * RandomPose(size, size, rng) * a_from_b;
  PoseInformation root;
  for (int i = 0; i < 6; ++i)
    root.row(i) << RandomVector(3, rng).transpose(), RandomVector(3, rng).transpose();
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

// InverseLeftJacobian() switches to its series between 1e-2 and 1e-3. A rotation vector with three
// components of 1.7 is almost pi.
TEST(AnalyticRelativePose, AgreesWithAutodiff) {
  std::mt19937_64 rng(5);
  for (const double size : {0., 1e-8, 1e-3, 0.0057, 1e-2, 0.1, 1., 1.7}) {
    for (int trial = 0; trial < 20; ++trial) ExpectAutodiffAgrees(size, &rng);
  }
}

}  // namespace
}  // namespace surfit::testing
