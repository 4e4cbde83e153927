// The prior's normal equations against RelativePose, derived by autodiff.
#include "refinement/motion_prior.h"

#include <ceres/autodiff_cost_function.h>
#include <gtest/gtest.h>

#include "cost_functions/pose_manifold.h"
#include "cost_functions/relative_pose.h"
#include "refinement/dense_hessian.h"
#include "refinement/random_surfels.h"
#include "testing/random_pose.h"

namespace surfit {
namespace {

using testing::DenseHessian;
using testing::MakeRandomProblem;
using testing::RandomPose;

constexpr double kSigmaM = 0.002, kSigmaRad = 0.005, kWeight = 3;
constexpr double kPrecision = 1e-9;  // sums of some dozens of products of double

// Three poses that have moved by less than the prior's robust kernel is wide.
class ThreePoses : public ::testing::Test {
 protected:
  ThreePoses() : given_(MakeRandomProblem(3, 1, 0).state), moved_(given_) {
    std::mt19937_64 random(3);
    for (Rigid3d& pose : moved_.world_from_camera) {
      pose = pose * RandomPose(0.2 * kSigmaRad, 0.2 * kSigmaM, &random);
    }
  }

  const BlockPattern pattern_ = {{}, 3};
  const JointState given_;
  JointState moved_;
};

TEST_F(ThreePoses, AreWhereTheyWereGiven) {
  const MotionPrior prior(given_.world_from_camera, kSigmaM, kSigmaRad);
  ReducedSystem system(pattern_);
  prior.AddTo(given_, &system);
  EXPECT_NEAR(system.rho, 0, kPrecision);
  EXPECT_LT(system.gradient.norm(), kPrecision / kSigmaM);
  // What moves all alike is free: six of 18 directions.
  EXPECT_EQ(DenseHessian(system).topLeftCorner(18, 18).fullPivLu().rank(), 12);
}

TEST_F(ThreePoses, AgreeWithAutodiff) {
  MotionPrior prior(given_.world_from_camera, kSigmaM, kSigmaRad);
  prior.SetWeight(kWeight);
  ReducedSystem system(pattern_);
  prior.AddTo(moved_, &system);
  EXPECT_NEAR(prior.Rho(moved_), system.rho, kPrecision * system.rho);

  PoseInformation information = PoseInformation::Identity();
  information.diagonal() << Eigen::Vector3d::Constant(1 / (kSigmaRad * kSigmaRad)),
      Eigen::Vector3d::Constant(1 / (kSigmaM * kSigmaM));
  Eigen::MatrixXd hessian = Eigen::MatrixXd::Zero(18, 18);
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(18);
  double rho = 0;
  for (int k = 0; k < 2; ++k) {
    using Functor = ceres::AutoDiffCostFunction<RelativePose, 6, kPoseSize, kPoseSize>;
    const Functor functor(new RelativePose(
        given_.world_from_camera[k].Inverse() * given_.world_from_camera[k + 1], information));
    double blocks[2][kPoseSize];
    PoseToBlock(moved_.world_from_camera[k], blocks[0]);
    PoseToBlock(moved_.world_from_camera[k + 1], blocks[1]);
    const double* poses[] = {blocks[0], blocks[1]};
    Eigen::Matrix<double, 6, kPoseSize, Eigen::RowMajor> by_block[2];
    double* jacobians[] = {by_block[0].data(), by_block[1].data()};
    Eigen::Matrix<double, 6, 1> residual;
    functor.Evaluate(poses, residual.data(), jacobians);
    Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(6, 18);
    for (int i = 0; i < 2; ++i) {
      Eigen::Matrix<double, kPoseSize, kPoseTangentSize, Eigen::RowMajor> plus;
      ProductPoseManifold().PlusJacobian(blocks[i], plus.data());
      jacobian.middleCols<kPoseTangentSize>(kPoseTangentSize * (k + i)) = by_block[i] * plus;
    }
    hessian += kWeight * jacobian.transpose() * jacobian;
    gradient += kWeight * jacobian.transpose() * residual;
    rho += kWeight * residual.squaredNorm();
  }
  const Eigen::MatrixXd ours = DenseHessian(system).topLeftCorner(18, 18);
  EXPECT_NEAR(system.rho, rho, kPrecision * rho);
  EXPECT_LT((ours - hessian).norm(), kPrecision * hessian.norm());
  EXPECT_LT((system.gradient.head(18) - gradient).norm(), kPrecision * gradient.norm());
}

TEST_F(ThreePoses, PullNoStrongerWhereTheyAreFarOff) {
  const MotionPrior prior(given_.world_from_camera, kSigmaM, kSigmaRad);
  const auto pull_at = [&](double metres) {
    JointState state = given_;
    state.world_from_camera[2].translation.x() += metres;
    ReducedSystem system(pattern_);
    prior.AddTo(state, &system);
    return system.gradient.norm();
  };
  EXPECT_NEAR(pull_at(100 * kSigmaM), pull_at(200 * kSigmaM), kPrecision * pull_at(100 * kSigmaM));
  EXPECT_NEAR(pull_at(2 * kSigmaM), 2 * pull_at(kSigmaM), 1e-6 * pull_at(kSigmaM));
}

}  // namespace
}  // namespace surfit
