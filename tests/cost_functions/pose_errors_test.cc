#include <gtest/gtest.h>

#include "cost_functions/pose_prior.h"
#include "cost_functions/relative_pose.h"
#include "cost_functions/solve_pose.h"
#include "testing/matchers.h"
#include "testing/random_pose.h"

namespace surfit {
namespace {

using testing::AsBlock;
using testing::PoseBlock;
using testing::RandomPose;
using testing::RandomVector;
using testing::RigidNear;

using Vector6 = Eigen::Matrix<double, 6, 1>;

// Full and far from diagonal.
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

TEST(PosePrior, CostIsTheInformationOfTheIncrementFromThePrior) {
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

TEST(RelativePose, CostIsTheInformationOfTheIncrementFromTheMeasurement) {
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

// A prior and a chain of exact relative poses hold all of them.
TEST(RelativePose, AChainOfPosesFollowsItsPrior) {
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
  testing::Solve(&problem);
  for (int i = 0; i < 5; ++i) {
    EXPECT_THAT(PoseFromBlock(poses[i].data()), RigidNear(truth[i], 1e-9, 1e-9)) << i;
  }
}

}  // namespace
}  // namespace surfit
