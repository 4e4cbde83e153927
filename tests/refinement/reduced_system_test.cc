// The system without displacements against the full one, derived by autodiff.
#include "refinement/reduced_system.h"

#include <ceres/autodiff_cost_function.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "cost_functions/plane_inverse_depth.h"
#include "cost_functions/pose_manifold.h"
#include "cost_functions/robust_kernel.h"
#include "refinement/joint_cost.h"
#include "refinement/random_surfels.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

using testing::MakeRandomProblem;
using testing::RandomProblem;

// All rows of the full problem, weighted: increments of the poses, calibration, displacements.
struct FullSystem {
  Eigen::MatrixXd jacobian;
  Eigen::VectorXd residuals;
  double rho = 0;
};

using Functor = ceres::AutoDiffCostFunction<PlaneInverseDepth, 1, kPoseSize, kCalibrationSize, 1>;

FullSystem MakeFull(const RandomProblem& problem, const RobustKernel& kernel) {
  const SharedSurfels& shared = problem.shared;
  const auto poses = static_cast<Eigen::Index>(problem.state.world_from_camera.size());
  const Eigen::Index calibration_begin = kPoseTangentSize * poses;
  const Eigen::Index surfels_begin = calibration_begin + kCalibrationSize;
  const auto rows = static_cast<Eigen::Index>(shared.observations.size());
  FullSystem full;
  full.jacobian =
      Eigen::MatrixXd::Zero(rows, surfels_begin + static_cast<Eigen::Index>(shared.surfels.size()));
  full.residuals = Eigen::VectorXd::Zero(rows);
  double calibration[kCalibrationSize];
  CalibrationToBlock(problem.state.calibration, calibration);
  for (std::size_t s = 0; s < shared.surfels.size(); ++s) {
    const SharedSurfel& surfel = shared.surfels[s];
    const double displacement = BestDisplacement(shared, surfel, problem.state, kernel);
    for (std::size_t i = surfel.begin; i < surfel.end; ++i) {
      const PlaneObservation& o = shared.observations[i];
      const Functor functor(new PlaneInverseDepth(o.u, o.v, o.inverse_depth, 1. / o.inverse_sigma,
                                                  surfel.point_in_world, surfel.normal_in_world));
      double pose[kPoseSize], residual, by_displacement;
      PoseToBlock(problem.state.world_from_camera[o.keyframe], pose);
      Eigen::Matrix<double, 1, kPoseSize> by_pose;
      Eigen::Matrix<double, 1, kCalibrationSize> by_calibration;
      const double* blocks[] = {pose, calibration, &displacement};
      double* jacobians[] = {by_pose.data(), by_calibration.data(), &by_displacement};
      functor.Evaluate(blocks, &residual, jacobians);
      Eigen::Matrix<double, kPoseSize, kPoseTangentSize, Eigen::RowMajor> plus;
      ProductPoseManifold().PlusJacobian(pose, plus.data());
      const KernelValue<double> value = EvaluateKernel(kernel, residual * residual);
      const double root = std::sqrt(value.slope);
      const auto row = static_cast<Eigen::Index>(i);
      full.rho += value.rho;
      full.residuals[row] = root * residual;
      full.jacobian.block<1, kPoseTangentSize>(row, kPoseTangentSize * o.keyframe) =
          root * by_pose * plus;
      full.jacobian.block<1, kCalibrationSize>(row, calibration_begin) = root * by_calibration;
      full.jacobian(row, surfels_begin + static_cast<Eigen::Index>(s)) = root * by_displacement;
    }
  }
  return full;
}

// Sums of products of some hundreds of rows of double; the pivots that stand for zero are at least
// 1e-12, each of some dozens.
constexpr double kPrecision = 1e-8;

class ReducedSystemOfKernel : public ::testing::TestWithParam<RobustKernelType> {
 protected:
  const RobustKernel kernel_ = {GetParam(), 1.5};
  const RandomProblem problem_ = MakeRandomProblem(6, 80, 1);
};

TEST_P(ReducedSystemOfKernel, IsTheSchurComplementOfTheFullOne) {
  const ReducedSystem reduced = Reduce(problem_.shared, problem_.state, kernel_);
  const FullSystem full = MakeFull(problem_, kernel_);
  const Eigen::Index kept = reduced.gradient.size();
  const Eigen::Index gone = full.jacobian.cols() - kept;
  const Eigen::MatrixXd hessian = full.jacobian.transpose() * full.jacobian;
  const Eigen::VectorXd gradient = full.jacobian.transpose() * full.residuals;
  const Eigen::LDLT<Eigen::MatrixXd> surfels(hessian.bottomRightCorner(gone, gone));
  const Eigen::MatrixXd mixed = hessian.topRightCorner(kept, gone);
  const Eigen::MatrixXd schur =
      hessian.topLeftCorner(kept, kept) - mixed * surfels.solve(mixed.transpose());
  const Eigen::VectorXd schur_gradient =
      gradient.head(kept) - mixed * surfels.solve(gradient.tail(gone));
  const Eigen::MatrixXd ours = reduced.hessian.selfadjointView<Eigen::Lower>();
  const Eigen::VectorXd scale = hessian.diagonal().head(kept).cwiseSqrt().cwiseInverse();
  EXPECT_LT((scale.asDiagonal() * (ours - schur) * scale.asDiagonal()).cwiseAbs().maxCoeff(),
            kPrecision);
  EXPECT_LT((scale.asDiagonal() * (reduced.gradient - schur_gradient)).cwiseAbs().maxCoeff(),
            kPrecision * full.residuals.norm());
  EXPECT_NEAR(reduced.rho, full.rho, kPrecision * full.rho);
}

TEST_P(ReducedSystemOfKernel, IsCarriedByTheCost) {
  const ReducedSystem reduced = Reduce(problem_.shared, problem_.state, kernel_);
  const MotionPrior none;
  const JointCost cost(problem_.shared, none, problem_.state, kernel_);
  const std::size_t poses = problem_.state.world_from_camera.size();
  std::vector<std::array<double, kPoseSize>> pose_blocks(poses);
  double calibration[kCalibrationSize];
  CalibrationToBlock(problem_.state.calibration, calibration);
  std::vector<const double*> blocks;
  for (std::size_t k = 0; k < poses; ++k) {
    PoseToBlock(problem_.state.world_from_camera[k], pose_blocks[k].data());
    blocks.push_back(pose_blocks[k].data());
  }
  blocks.push_back(calibration);
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const int rows = cost.num_residuals();
  std::vector<RowMajor> by_pose(poses, RowMajor(rows, kPoseSize));
  RowMajor by_calibration(rows, kCalibrationSize);
  std::vector<double*> jacobians;
  for (RowMajor& jacobian : by_pose) jacobians.push_back(jacobian.data());
  jacobians.push_back(by_calibration.data());
  Eigen::VectorXd residuals(rows), cost_only(rows);
  ASSERT_TRUE(cost.Evaluate(blocks.data(), residuals.data(), jacobians.data()));
  ASSERT_TRUE(cost.Evaluate(blocks.data(), cost_only.data(), nullptr));
  EXPECT_NEAR(residuals.squaredNorm(), reduced.rho, kPrecision * reduced.rho);
  EXPECT_NEAR(cost_only.squaredNorm(), reduced.rho, kPrecision * reduced.rho);

  Eigen::MatrixXd jacobian(rows, reduced.gradient.size());
  for (std::size_t k = 0; k < poses; ++k) {
    Eigen::Matrix<double, kPoseSize, kPoseTangentSize, Eigen::RowMajor> plus;
    ProductPoseManifold().PlusJacobian(pose_blocks[k].data(), plus.data());
    jacobian.middleCols<kPoseTangentSize>(kPoseTangentSize * k) = by_pose[k] * plus;
  }
  jacobian.rightCols<kCalibrationSize>() = by_calibration;
  const Eigen::MatrixXd hessian = reduced.hessian.selfadjointView<Eigen::Lower>();
  const Eigen::VectorXd scale = hessian.diagonal().cwiseSqrt().cwiseInverse();
  EXPECT_LT((scale.asDiagonal() * (jacobian.transpose() * jacobian - hessian) * scale.asDiagonal())
                .cwiseAbs()
                .maxCoeff(),
            kPrecision);
  EXPECT_LT((scale.asDiagonal() * (jacobian.transpose() * residuals - reduced.gradient))
                .cwiseAbs()
                .maxCoeff(),
            kPrecision * residuals.norm());
}

INSTANTIATE_TEST_SUITE_P(Kernels, ReducedSystemOfKernel,
                         ::testing::Values(RobustKernelType::kNone, RobustKernelType::kHuber,
                                           RobustKernelType::kGemanMcClure));

TEST(ReducedSystemThreads, IsTheSameBitForBit) {
  const RandomProblem problem = MakeRandomProblem(6, 80, 1);
  const auto reduce = [&](int threads) {
    const ThreadLimit limit(threads);
    return Reduce(problem.shared, problem.state, {RobustKernelType::kGemanMcClure, 3});
  };
  const ReducedSystem one = reduce(1), three = reduce(3);
  EXPECT_EQ(one.hessian, three.hessian);
  EXPECT_EQ(one.gradient, three.gradient);
  EXPECT_EQ(one.rho, three.rho);
}

}  // namespace
}  // namespace surfit
