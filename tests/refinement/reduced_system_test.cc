// The system without displacements against the full one, derived by autodiff.
#include "refinement/reduced_system.h"

#include <ceres/autodiff_cost_function.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "cost_functions/plane_inverse_depth.h"
#include "cost_functions/pose_manifold.h"
#include "cost_functions/robust_kernel.h"
#include "refinement/calibration_block.h"
#include "refinement/dense_hessian.h"
#include "refinement/random_surfels.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

using testing::DenseHessian;
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

// Of all pairs of poses about half share a surfel.
class ReducedSystemOfKernel : public ::testing::TestWithParam<RobustKernelType> {
 protected:
  const RobustKernel kernel_ = {GetParam(), 1.5};
  const RandomProblem problem_ = MakeRandomProblem(8, 80, 1, 2);
  const BlockPattern pattern_ = {problem_.shared, 8};
};

TEST_P(ReducedSystemOfKernel, IsTheSchurComplementOfTheFullOne) {
  const ReducedSystem reduced = Reduce(problem_.shared, pattern_, problem_.state, kernel_);
  ASSERT_LT(pattern_.block_count(), 8 * 9 / 2);
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
  const Eigen::MatrixXd ours = DenseHessian(reduced);
  const Eigen::VectorXd scale = hessian.diagonal().head(kept).cwiseSqrt().cwiseInverse();
  EXPECT_LT((scale.asDiagonal() * (ours - schur) * scale.asDiagonal()).cwiseAbs().maxCoeff(),
            kPrecision);
  EXPECT_LT((scale.asDiagonal() * (reduced.gradient - schur_gradient)).cwiseAbs().maxCoeff(),
            kPrecision * full.residuals.norm());
  EXPECT_NEAR(reduced.rho, full.rho, kPrecision * full.rho);
}

INSTANTIATE_TEST_SUITE_P(Kernels, ReducedSystemOfKernel,
                         ::testing::Values(RobustKernelType::kNone, RobustKernelType::kHuber,
                                           RobustKernelType::kGemanMcClure));

TEST(ReducedSystemThreads, IsTheSameBitForBit) {
  const RandomProblem problem = MakeRandomProblem(6, 80, 1);
  const BlockPattern pattern(problem.shared, 6);
  const auto reduce = [&](int threads) {
    const ThreadLimit limit(threads);
    return Reduce(problem.shared, pattern, problem.state, {RobustKernelType::kGemanMcClure, 3});
  };
  const ReducedSystem one = reduce(1), three = reduce(3);
  EXPECT_EQ(one.poses, three.poses);
  EXPECT_EQ(one.mixed, three.mixed);
  EXPECT_EQ(one.calibration, three.calibration);
  EXPECT_EQ(one.gradient, three.gradient);
  EXPECT_EQ(one.rho, three.rho);
}

}  // namespace
}  // namespace surfit
