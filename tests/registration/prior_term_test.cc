#include <ceres/autodiff_cost_function.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "cost_functions/pose_manifold.h"
#include "cost_functions/pose_prior.h"
#include "registration/three_planes.h"
#include "surfit/registration/icp.h"
#include "surfit/registration/pose_solver.h"
#include "testing/matchers.h"
#include "testing/random_pose.h"

namespace surfit::testing {
namespace {

Matrix6d PositiveMatrix(double scale, std::mt19937_64* rng) {
  std::normal_distribution<double> normal;
  Matrix6d factor;
  for (double& value : factor.reshaped()) value = normal(*rng);
  return scale * (factor * factor.transpose() + 0.1 * Matrix6d::Identity());
}

TEST(PriorTerm, RowsAreThoseOfTheCeresFunctor) {
  std::mt19937_64 rng(3);
  for (int i = 0; i < 20; ++i) {
    const PriorTerm prior = {RandomPose(1, 1, &rng), PositiveMatrix(1, &rng)};
    const Rigid3d pose = LeftIncrement<double>(0.3 * Vector6d::Unit(i % 6) + 0.1 * Vector6d::Ones(),
                                               RandomPose(1, 1, &rng));
    const ceres::AutoDiffCostFunction<PosePrior, 6, kPoseSize> functor(
        new PosePrior(prior.target_from_source, prior.information));
    double block[kPoseSize];
    PoseToBlock(pose, block);
    const double* blocks[] = {block};
    Vector6d residuals;
    Eigen::Matrix<double, 6, kPoseSize, Eigen::RowMajor> by_block;
    double* jacobians[] = {by_block.data()};
    ASSERT_TRUE(functor.Evaluate(blocks, residuals.data(), jacobians));
    Eigen::Matrix<double, kPoseSize, 6, Eigen::RowMajor> block_by_increment;
    LeftPoseManifold().PlusJacobian(block, block_by_increment.data());
    const Matrix6d jacobian = by_block * block_by_increment;
    const PriorRows rows = prior.RowsAt(pose);
    EXPECT_LT((rows.col(6) - residuals).norm(), 1e-9 * (1 + residuals.norm())) << i;
    EXPECT_LT((rows.leftCols<6>() - jacobian).norm(), 1e-9 * jacobian.norm()) << i;
  }
}

// Two views of a corner with three planes, or of a bare plane.
class PriorSolvers : public ::testing::TestWithParam<std::string> {
 protected:
  explicit PriorSolvers(int planes = 3)
      : target_(RenderCorner(PoseBeforeTheCorner(), planes)),
        source_(RenderCorner(PoseBeforeTheCorner(), planes)) {}

  // Repeats steps from the identity, with new correspondences at each pose.
  Rigid3d Minimum(const std::string& solver, const PriorTerm* prior) const {
    PoseSolverOptions options;
    options.name = solver;
    const auto pose_solver = MakePoseSolver(options);
    if (prior != nullptr) pose_solver->Use(*prior);
    Rigid3d pose;
    for (int i = 0; i < 25; ++i) {
      pose = LeftIncrement<double>(pose_solver->Step(association_, pose).increment, pose);
    }
    return pose;
  }
  StepResult FirstStep(const std::string& solver, const PriorTerm* prior) const {
    PoseSolverOptions options;
    options.name = solver;
    const auto pose_solver = MakePoseSolver(options);
    if (prior != nullptr) pose_solver->Use(*prior);
    return pose_solver->Step(association_, Rigid3d());
  }
  // Prior that is wrong by about 1 cm and 0.01 rad. `ratio`: its information relative to that of
  // the data.
  PriorTerm WrongPrior(double ratio) const {
    const Matrix6d hessian = FirstStep("closed_form_ldlt", nullptr).system.hessian;
    const Rigid3d pose(QuaternionExp<double>({0.01, -0.004, 0.006}), {0.012, -0.008, 0.01});
    return {pose, ratio * Matrix6d(hessian.diagonal().asDiagonal())};
  }

  FrameLevel target_, source_;
  ProjectiveAssociation association_{target_, source_, AssociationGates(), ErrorModel(),
                                     NeededNormals::kBoth};
};

TEST_P(PriorSolvers, GiveTheSamePose) {
  for (const double ratio : {0.01, 1., 100.}) {
    const PriorTerm prior = WrongPrior(ratio);
    const Rigid3d expected = Minimum("closed_form_ldlt", &prior);
    EXPECT_GT(FirstOrderIncrement(expected, prior.target_from_source).norm(), 1e-5);
    EXPECT_GT(FirstOrderIncrement(expected, Rigid3d()).norm(), 1e-5);
    EXPECT_THAT(Minimum(GetParam(), &prior), RigidNear(expected, 1e-6, 1e-6)) << ratio;
  }
}

// The information of the data is that of a step without the prior.
TEST_P(PriorSolvers, ReportTheSystemWithoutThePrior) {
  const PriorTerm prior = WrongPrior(1);
  const StepResult with = FirstStep(GetParam(), &prior);
  const StepResult without = FirstStep(GetParam(), nullptr);
  EXPECT_GT(with.prior_cost, 0);
  EXPECT_NE(with.increment, without.increment);
  EXPECT_EQ(with.system.hessian, without.system.hessian);
  EXPECT_EQ(with.system.right_side, without.system.right_side);
  EXPECT_EQ(with.system.JointCost(), without.system.JointCost());
  EXPECT_EQ(with.observability.eigenvalues, without.observability.eigenvalues);
}

INSTANTIATE_TEST_SUITE_P(Solvers, PriorSolvers, ::testing::ValuesIn(PointToPlaneSolverNames()),
                         [](const auto& instance) { return instance.param; });

// A plane leaves three directions open. The prior gives the pose along these directions.
class PriorBeforeAPlane : public PriorSolvers {
 protected:
  PriorBeforeAPlane() : PriorSolvers(1) {}
};

TEST_P(PriorBeforeAPlane, HoldsUnobservableDirections) {
  PriorTerm prior = WrongPrior(0.01);
  prior.information += 1e-3 * Matrix6d::Identity();
  const Observability data = FirstStep(GetParam(), nullptr).observability;
  ASSERT_EQ(data.degenerate_count, 3);
  const Rigid3d pose = Minimum(GetParam(), &prior);
  const Vector6d from_prior = FirstOrderIncrement(prior.target_from_source, pose);
  EXPECT_THAT(pose, RigidNear(Minimum("closed_form_ldlt", &prior), 1e-6, 1e-6));
  EXPECT_GT(FirstOrderIncrement(Rigid3d(), pose).norm(), 5e-3);
  EXPECT_GT(from_prior.norm(), 1e-3);
  EXPECT_LT((prior.target_from_source.rotation.angularDistance(pose.rotation)), 0.02);
}

INSTANTIATE_TEST_SUITE_P(Solvers, PriorBeforeAPlane, ::testing::ValuesIn(PointToPlaneSolverNames()),
                         [](const auto& instance) { return instance.param; });

TEST(RegisterWithPrior, ReportsInformationWithoutThePrior) {
  const FramePyramid view = OneLevel(RenderCorner(PoseBeforeTheCorner()));
  const IcpOptions options;
  const IcpResult registered = Register(view, view, Rigid3d(), options);
  ASSERT_TRUE(registered.Succeeded());
  const PriorTerm prior = {registered.target_from_source, 1e3 * registered.information};
  const IcpResult with =
      RegisterWithPrior(view, view, registered.target_from_source, prior, options);
  EXPECT_THAT(with.target_from_source, RigidNear(registered.target_from_source, 1e-6, 1e-6));
  EXPECT_LT((with.information - registered.information).norm(),
            1e-3 * registered.information.norm());
  EXPECT_LT((with.trusted_information - registered.trusted_information).norm(),
            0.1 * registered.trusted_information.norm());
}

TEST(RegisterWithPrior, RejectsSvd) {
  const FramePyramid view = OneLevel(RenderCorner(PoseBeforeTheCorner()));
  IcpOptions options;
  options.solver = "svd";
  options.residual = "point_to_point";
  const PriorTerm prior = {Rigid3d(), Matrix6d::Identity()};
  ExpectInputError([&] { RegisterWithPrior(view, view, Rigid3d(), prior, options); },
                   Names("solver", "svd"));
}

}  // namespace
}  // namespace surfit::testing
