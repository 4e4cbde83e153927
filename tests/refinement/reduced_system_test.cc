// Compares the reduced system with the full system, derived by autodiff. Compares the block
// factorisation with dense solutions of the whole system.
#include "optimization/refinement/reduced_system.h"

#include <ceres/autodiff_cost_function.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>

#include "cost_functions/plane_inverse_depth.h"
#include "cost_functions/pose_manifold.h"
#include "cost_functions/robust_kernel.h"
#include "optimization/refinement/joint_state.h"
#include "optimization/refinement/reduced_factor.h"
#include "refinement/random_surfels.h"
#include "surfit/core/parallel.h"

namespace surfit::testing {
namespace {

// Weighted rows of the full problem. Columns: increments of the poses, calibration, displacements.
struct FullSystem {
  Eigen::MatrixXd jacobian;
  Eigen::VectorXd residuals;
  double rho = 0;
};

using PlaneFunctor =
    ceres::AutoDiffCostFunction<PlaneInverseDepth, 1, kPoseSize, kCalibrationSize, 1>;
using TextureFunctor =
    ceres::AutoDiffCostFunction<SurfelTexture, 2, kPoseSize, kCalibrationSize, 1, 2>;

// Builds the full system. All surfels have columns for texture, which are zero without texture.
class FullMaker {
 public:
  FullMaker(const RandomProblem& problem, const JointKernels& kernels)
      : problem_(problem), kernels_(kernels), placed_(problem.state) {
    const SharedSurfels& shared = problem.shared;
    const auto rows =
        static_cast<Eigen::Index>(shared.observations.size() + 2 * shared.textures.size());
    full_.jacobian = Eigen::MatrixXd::Zero(
        rows,
        SurfelsBegin() + kTexturedUnknowns * static_cast<Eigen::Index>(shared.surfels.size()));
    full_.residuals = Eigen::VectorXd::Zero(rows);
    CalibrationToBlock(problem.state.calibration, calibration_);
  }

  FullSystem Make() {
    const SharedSurfels& shared = problem_.shared;
    for (std::size_t s = 0; s < shared.surfels.size(); ++s) {
      const SharedSurfel& surfel = shared.surfels[s];
      const SurfelParameters best = SurfelResiduals(shared, surfel, placed_).Best(kernels_);
      for (std::size_t i = surfel.begin; i < surfel.end; ++i) AddPlane(s, best, i);
      for (std::size_t i = surfel.textures_begin; i < surfel.textures_end; ++i) {
        AddTexture(s, best, i);
      }
    }
    return full_;
  }

 private:
  Eigen::Index CalibrationBegin() const {
    return kPoseTangentSize * static_cast<Eigen::Index>(problem_.state.world_from_camera.size());
  }
  Eigen::Index SurfelsBegin() const { return CalibrationBegin() + kCalibrationSize; }

  void AddPlane(std::size_t s, const SurfelParameters& best, std::size_t i) {
    const SharedSurfel& surfel = problem_.shared.surfels[s];
    const PlaneObservation& o = problem_.shared.observations[i];
    const RowMotion motion =
        MotionOf(o, problem_.shared.readouts[o.keyframe], problem_.state.calibration.camera.height);
    const PlaneFunctor functor(new PlaneInverseDepth(o.u, o.v, o.inverse_depth,
                                                     1. / o.inverse_sigma, surfel.point_in_world,
                                                     surfel.normal_in_world, motion));
    Add(functor, o.keyframe, s, best.displacement, nullptr, kernels_.plane);
  }

  void AddTexture(std::size_t s, const SurfelParameters& best, std::size_t i) {
    const SharedSurfel& surfel = problem_.shared.surfels[s];
    const TextureObservation& o = problem_.shared.textures[i];
    const TextureFunctor functor(new SurfelTexture(o.taps, 1. / o.inverse_sigma,
                                                   TexturePoints(surfel), surfel.normal_in_world));
    // The functor uses the unit of sigma. The elimination uses standard deviations.
    const Eigen::Vector2d texture = best.texture / o.inverse_sigma;
    Add(functor, o.keyframe, s, best.displacement, texture.data(), kernels_.texture);
  }

  // Adds the rows of one functor. `texture` is null for functors without texture.
  void Add(const ceres::CostFunction& functor, int keyframe, std::size_t s, double displacement,
           const double* texture, const RobustKernel& kernel) {
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    const int rows = functor.num_residuals();
    double pose[kPoseSize];
    PoseToBlock(problem_.state.world_from_camera[keyframe], pose);
    Eigen::VectorXd residuals(rows), by_displacement(rows);
    RowMajor by_pose(rows, kPoseSize), by_calibration(rows, kCalibrationSize), by_texture(rows, 2);
    const double* blocks[] = {pose, calibration_, &displacement, texture};
    double* jacobians[] = {by_pose.data(), by_calibration.data(), by_displacement.data(),
                           by_texture.data()};
    ASSERT_TRUE(functor.Evaluate(blocks, residuals.data(), jacobians));
    Eigen::Matrix<double, kPoseSize, kPoseTangentSize, Eigen::RowMajor> plus;
    ProductPoseManifold().PlusJacobian(pose, plus.data());
    const KernelValue<double> value = EvaluateKernel(kernel, residuals.squaredNorm());
    const double root = std::sqrt(value.slope);
    full_.rho += value.rho;
    full_.residuals.segment(row_, rows) = root * residuals;
    auto jacobian = full_.jacobian.middleRows(row_, rows);
    const Eigen::Index surfel = SurfelsBegin() + kTexturedUnknowns * static_cast<Eigen::Index>(s);
    jacobian.middleCols(kPoseTangentSize * keyframe, kPoseTangentSize) = root * by_pose * plus;
    jacobian.middleCols(CalibrationBegin(), kCalibrationSize) = root * by_calibration;
    jacobian.col(surfel) = root * by_displacement;
    if (texture != nullptr) jacobian.middleCols(surfel + 1, 2) = root * by_texture;
    row_ += rows;
  }

  const RandomProblem& problem_;
  const JointKernels& kernels_;
  PlacedPoses placed_;
  FullSystem full_;
  double calibration_[kCalibrationSize];
  Eigen::Index row_ = 0;
};

// Sums of products of a few hundred rows in double precision. Pivots that replace zeros are at
// least 1e-12, each a sum of a few dozen products.
constexpr double kOfReduction = 1e-8;

// About half of all pairs of poses share a surfel.
class ReducedSystemOfKernel : public ::testing::TestWithParam<RobustKernelType> {
 protected:
  // The readout differs from the readout of the image correction.
  ReducedSystemOfKernel() { problem_.state.calibration.readout_s += 0.01; }

  const JointKernels kernels_ = {{GetParam(), 1.5}, {GetParam(), 0.7}};
  RandomProblem problem_ = MakeRandomProblem(8, 80, 1, 2);
  const BlockPattern pattern_ = {problem_.shared, 8};
};

TEST_P(ReducedSystemOfKernel, IsSchurComplementOfFullSystem) {
  const ReducedSystem reduced = Reduce(problem_.shared, pattern_, problem_.state, kernels_);
  ASSERT_LT(pattern_.block_count(), 8 * 9 / 2);
  const FullSystem full = FullMaker(problem_, kernels_).Make();
  const Eigen::Index kept = reduced.gradient.size();
  const Eigen::Index gone = full.jacobian.cols() - kept;
  Eigen::MatrixXd hessian = full.jacobian.transpose() * full.jacobian;
  // Diagonal of parameters without observation.
  hessian.diagonal() = hessian.diagonal().unaryExpr([](double d) { return d > 0 ? d : 1.; });
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
            kOfReduction);
  EXPECT_LT((scale.asDiagonal() * (reduced.gradient - schur_gradient)).cwiseAbs().maxCoeff(),
            kOfReduction * full.residuals.norm());
  EXPECT_NEAR(reduced.rho, full.rho, kOfReduction * full.rho);
}

INSTANTIATE_TEST_SUITE_P(Kernels, ReducedSystemOfKernel,
                         ::testing::Values(RobustKernelType::kNone, RobustKernelType::kHuber,
                                           RobustKernelType::kGemanMcClure));

TEST(ReducedSystemThreads, IsBitwiseIdentical) {
  const RandomProblem problem = MakeRandomProblem(6, 80, 1);
  const BlockPattern pattern(problem.shared, 6);
  const auto reduce = [&](int threads) {
    const ThreadLimit limit(threads);
    return Reduce(problem.shared, pattern, problem.state,
                  {{RobustKernelType::kGemanMcClure, 3}, {RobustKernelType::kHuber, 1.5}});
  };
  const ReducedSystem one = reduce(1), three = reduce(3);
  EXPECT_EQ(one.poses, three.poses);
  EXPECT_EQ(one.mixed, three.mixed);
  EXPECT_EQ(one.calibration, three.calibration);
  EXPECT_EQ(one.gradient, three.gradient);
  EXPECT_EQ(one.rho, three.rho);
}

constexpr int kManyPoses = 40, kManySurfels = 2000;
constexpr double kDamping = 1e-4;
// With a diagonal of ones, the condition number is below 1 / kDamping, or 1e6 without damping. Sums
// have a few hundred products.
constexpr double kFactorPrecision = 1e-9;

// Poses along a corridor (sparse), or in front of one wall (dense).
struct View {
  int reach;
  bool dense;
};

class ReducedFactorOfView : public ::testing::TestWithParam<View> {
 protected:
  ReducedFactorOfView() {
    held_[1] = held_[7] = true;
    for (int i = 0; i < kCalibrationSize; ++i) {
      if (!held_[i]) free_.push_back(kPoseTangentSize * kManyPoses + i);
    }
    for (int i = kPoseTangentSize * kManyPoses - 1; i >= kPoseTangentSize; --i) {
      free_.insert(free_.begin(), i);
    }
  }

  const RandomProblem problem_ = MakeRandomProblem(kManyPoses, kManySurfels, 1, GetParam().reach);
  const BlockPattern pattern_ = {problem_.shared, kManyPoses};
  const ReducedSystem system_ = Reduce(problem_.shared, pattern_, problem_.state, {});
  const Eigen::MatrixXd hessian_ = DenseHessian(system_);
  std::vector<bool> held_ = std::vector<bool>(kCalibrationSize, false);
  std::vector<Eigen::Index> free_;
};

TEST_P(ReducedFactorOfView, UsesFasterFactorization) {
  EXPECT_EQ(PoseFactor(pattern_).is_dense(), GetParam().dense);
}

TEST_P(ReducedFactorOfView, SolvesForDampedStep) {
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
            kFactorPrecision * embedded.cwiseProduct(root).norm());
  const double model = -2 * gradient.dot(expected) - expected.dot(free * expected);
  EXPECT_NEAR(step.rho_decrease, model, kFactorPrecision * model);
}

TEST_P(ReducedFactorOfView, AgreesWithBlocksOfInverse) {
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
  constexpr double kOfInverse = 1e-6;  // pivots of 1e-12, and a condition number below 1e6
  EXPECT_LT(difference(covariance.calibration, kPoseTangentSize * kManyPoses), kOfInverse);
  ASSERT_EQ(covariance.poses.size(), std::size_t{kManyPoses});
  for (int k = 0; k < kManyPoses; ++k) {
    EXPECT_LT(difference(covariance.poses[k], kPoseTangentSize * k), kOfInverse) << k;
  }
}

// The full step is the minimum of the marginal cost, and the inverse of its Hessian is the
// covariance.
TEST_P(ReducedFactorOfView, HasMarginalCostOfCalibration) {
  const CalibrationModel model = MarginalOf(system_, held_);
  const Eigen::MatrixXd free = hessian_(free_, free_);
  Eigen::VectorXd step = Eigen::VectorXd::Zero(hessian_.rows());
  const Eigen::VectorXd gradient = system_.gradient(free_);
  step(free_) = Eigen::VectorXd(-free.partialPivLu().solve(gradient));
  const CalibrationRow at_minimum = step.tail<kCalibrationSize>();
  Eigen::MatrixXd inverse = Eigen::MatrixXd::Zero(hessian_.rows(), hessian_.cols());
  inverse(free_, free_) = Eigen::MatrixXd(free.inverse());
  const ReducedSystem::CalibrationMatrix covariance =
      inverse.bottomRightCorner<kCalibrationSize, kCalibrationSize>();
  const CalibrationRow sigma = covariance.diagonal().cwiseSqrt();
  constexpr double kTolerance = 1e-5;  // pivots of 1e-12, and a condition number below 1e6
  const CalibrationRow rest = model.gradient + model.information * at_minimum;
  EXPECT_LT(rest.cwiseProduct(sigma).norm(),
            kTolerance * model.gradient.cwiseProduct(sigma).norm());
  const ReducedSystem::CalibrationMatrix product = model.information * covariance;
  for (int i = 0; i < kCalibrationSize; ++i) {
    for (int j = 0; j < kCalibrationSize; ++j) {
      if (held_[i] || held_[j]) {
        EXPECT_EQ(model.information(i, j), 0);
        continue;
      }
      EXPECT_NEAR(product(i, j) * sigma[i] / sigma[j], i == j, kTolerance) << i << " " << j;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Views, ReducedFactorOfView,
                         ::testing::Values(View{1, false}, View{kManyPoses, true}));

TEST(ReducedFactor, KeepsPoseWithoutObservations) {
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
}  // namespace surfit::testing
