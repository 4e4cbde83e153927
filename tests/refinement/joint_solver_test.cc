// Compares the joint solver with Ceres over all rows, including displacements. The reference uses
// autodiff. Compares the normal equations of the prior with autodiff of RelativePose.
#include "optimization/refinement/joint_solver.h"

#include <ceres/autodiff_cost_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>
#include <gtest/gtest.h>

#include <array>

#include "cost_functions/pose_manifold.h"
#include "cost_functions/relative_pose.h"
#include "optimization/refinement/joint_state.h"
#include "refinement/random_surfels.h"
#include "testing/random_pose.h"

namespace surfit::testing {
namespace {

constexpr int kPoses = 12, kSurfels = 600;

double CeresCost(const RandomProblem& problem) {
  using Plane = ceres::AutoDiffCostFunction<PlaneInverseDepth, 1, kPoseSize, kCalibrationSize, 1>;
  using Texture = ceres::AutoDiffCostFunction<SurfelTexture, 2, kPoseSize, kCalibrationSize, 1, 2>;
  std::vector<std::array<double, kPoseSize>> poses(kPoses);
  std::array<double, kCalibrationSize> calibration;
  std::vector<double> displacements(problem.shared.surfels.size(), 0.);
  std::vector<std::array<double, 2>> textures(displacements.size(), {0, 0});
  CalibrationToBlock(problem.state.calibration, calibration.data());
  ceres::Problem ceres_problem;
  for (int k = 0; k < kPoses; ++k) {
    PoseToBlock(problem.state.world_from_camera[k], poses[k].data());
    ceres_problem.AddParameterBlock(poses[k].data(), kPoseSize, new ProductPoseManifold);
  }
  ceres_problem.SetParameterBlockConstant(poses[0].data());
  for (std::size_t s = 0; s < displacements.size(); ++s) {
    const SharedSurfel& surfel = problem.shared.surfels[s];
    for (std::size_t i = surfel.begin; i < surfel.end; ++i) {
      const PlaneObservation& o = problem.shared.observations[i];
      const RowMotion motion =
          MotionOf(o, problem.shared.readouts[o.keyframe], problem.state.calibration.camera.height);
      ceres_problem.AddResidualBlock(
          new Plane(new PlaneInverseDepth(o.u, o.v, o.inverse_depth, 1. / o.inverse_sigma,
                                          surfel.point_in_world, surfel.normal_in_world, motion)),
          nullptr, poses[o.keyframe].data(), calibration.data(), &displacements[s]);
    }
    for (std::size_t i = surfel.textures_begin; i < surfel.textures_end; ++i) {
      const TextureObservation& o = problem.shared.textures[i];
      ceres_problem.AddResidualBlock(
          new Texture(new SurfelTexture(o.taps, 1. / o.inverse_sigma, TexturePoints(surfel),
                                        surfel.normal_in_world)),
          nullptr, poses[o.keyframe].data(), calibration.data(), &displacements[s],
          textures[s].data());
    }
  }
  // Only the offset of inverse depth is estimated. The other ten parameters are fixed.
  std::vector<int> held(kCalibrationSize);
  for (int i = 0; i < kCalibrationSize; ++i) held[i] = i;
  held.erase(held.begin() + kFieldBegin);
  ceres_problem.SetManifold(calibration.data(), new ceres::SubsetManifold(kCalibrationSize, held));
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.max_num_iterations = 100;
  options.function_tolerance = 1e-12;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &ceres_problem, &summary);
  return summary.final_cost;
}

TEST(MinimizeJointly, ReachesCostOfCeres) {
  for (const int reach : {1, kPoses}) {
    RandomProblem problem = MakeRandomProblem(kPoses, kSurfels, 1, reach);
    std::mt19937_64 random(3);
    for (int k = 1; k < kPoses; ++k) {
      Rigid3d& pose = problem.state.world_from_camera[k];
      pose = pose * RandomPose(0.01, 0.02, &random);
    }
    problem.state.calibration.field.coefficients[0] += 0.005;
    const JointKernels none = {{RobustKernelType::kNone, 1}, {RobustKernelType::kNone, 1}};
    RefinementOptions options;
    options.estimate_intrinsics = options.estimate_depth_field = options.estimate_readout = false;
    options.max_iterations = 100;
    const Rigid3d first = problem.state.world_from_camera[0];
    const double before = FitOf(problem.shared, problem.state, none).rho / 2;
    const double expected = CeresCost(problem);
    const JointPrior nothing;
    ASSERT_GT(MinimizeJointly({problem.shared, nothing, none}, options, &problem.state).iterations,
              0);
    const double cost = FitOf(problem.shared, problem.state, none).rho / 2;
    EXPECT_LT(expected, before / 2);  // the initial cost is larger
    // Both costs are minimal, up to the convergence threshold 1e-6.
    EXPECT_NEAR(cost, expected, 1e-6 * expected);
    EXPECT_EQ(problem.state.world_from_camera[0].Matrix(), first.Matrix());
  }
}

TEST(MinimizeJointly, KeepsStateWithoutFiniteCost) {
  for (const char* solver : {"reduced", "ceres"}) {
    SCOPED_TRACE(solver);
    RandomProblem problem = MakeRandomProblem(kPoses, kSurfels, 1);
    problem.shared.observations[0].inverse_depth = std::nanf("");
    const Rigid3d last = problem.state.world_from_camera.back();
    const JointPrior nothing;
    RefinementOptions options;
    options.solver = solver;
    const JointReport report =
        MinimizeJointly({problem.shared, nothing, {}}, options, &problem.state);
    EXPECT_EQ(report.iterations, kNoSolution);
    EXPECT_EQ(problem.state.world_from_camera.back().Matrix(), last.Matrix());
  }
}

constexpr double kSigmaM = 0.002, kSigmaRad = 0.005, kWeight = 3;
constexpr double kPrecision = 1e-9;  // sums of a few dozen products in double precision

// Three poses with errors below the width of the robust kernel of the prior.
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

TEST_F(ThreePoses, PriorIsZeroAtInputPoses) {
  const JointPrior prior(given_.world_from_camera, kSigmaM, kSigmaRad);
  ReducedSystem system(pattern_);
  prior.AddTo(given_, &system);
  EXPECT_NEAR(system.rho, 0, kPrecision);
  EXPECT_LT(system.gradient.norm(), kPrecision / kSigmaM);
  // A common motion of all poses is unobservable: six of 18 directions.
  EXPECT_EQ(DenseHessian(system).topLeftCorner(18, 18).fullPivLu().rank(), 12);
}

TEST_F(ThreePoses, PriorAgreesWithAutodiff) {
  JointPrior prior(given_.world_from_camera, kSigmaM, kSigmaRad);
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

TEST_F(ThreePoses, PriorIsRobustToLargeErrors) {
  const JointPrior prior(given_.world_from_camera, kSigmaM, kSigmaRad);
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

// The cost is the sum of squared changes, in standard deviations. The gradient is half the slope of
// rho.
TEST_F(ThreePoses, CalibrationPriorIsSumOfSquares) {
  const CalibrationPrior sigmas = {0.01, 0.001, 5, 0.02};
  JointPrior prior(given_.calibration, sigmas);
  prior.SetWeight(kWeight);
  EXPECT_EQ(prior.Rho(given_), 0);
  JointState wrong = given_;
  PinholeCamera& camera = wrong.calibration.camera;
  camera.fx *= 1.01, camera.cy += 10, wrong.calibration.field.coefficients[3] -= 0.02;
  // 1 for the focal length, 10^2 for the aspect, 2^2 for the centre, 1 for the field.
  EXPECT_NEAR(prior.Rho(wrong), kWeight * (1 + 100 + 4 + 1), 1e-6);
  ReducedSystem system(pattern_);
  prior.AddTo(wrong, &system);
  EXPECT_NEAR(system.rho, prior.Rho(wrong), kPrecision * system.rho);
  EXPECT_EQ(system.gradient.head(system.CalibrationBegin()).norm(), 0);
  // rho is quadratic: a Newton step leads to the input calibration.
  const Eigen::VectorXd step =
      system.calibration.ldlt().solve(system.gradient.tail<kCalibrationSize>());
  EXPECT_NEAR(step[0], wrong.calibration.camera.fx - given_.calibration.camera.fx, 1e-9);
  EXPECT_NEAR(step[3], 10, 1e-9);
  EXPECT_NEAR(step[kFieldBegin + 3], -0.02, 1e-9);
}

TEST_F(ThreePoses, CalibrationPriorIsZeroWithoutStandardDeviations) {
  const JointPrior prior(given_.calibration, CalibrationPrior{0, 0, 0, 0});
  JointState wrong = given_;
  wrong.calibration.camera.fx *= 2;
  EXPECT_EQ(prior.Rho(wrong), 0);
}

}  // namespace
}  // namespace surfit::testing
