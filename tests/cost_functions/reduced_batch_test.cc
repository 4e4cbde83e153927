#include "cost_functions/reduced_batch.h"

#include <gtest/gtest.h>

#include "cost_functions/random_functors.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr RobustKernelType kKernels[] = {RobustKernelType::kNone, RobustKernelType::kHuber,
                                         RobustKernelType::kTukey, RobustKernelType::kGemanMcClure,
                                         RobustKernelType::kStudentT};

// Cost 1/2 sum rho, its gradient and Gauss-Newton matrix, and sums of absolute terms, which bound
// the rounding errors.
struct Expansion {
  double cost = 0;
  Vector6 gradient = Vector6::Zero();
  Matrix6 hessian = Matrix6::Zero();
  Vector6 gradient_terms = Vector6::Zero();
  Vector6 hessian_terms = Vector6::Zero();  // diagonal, with positive terms
};

Eigen::Matrix<double, kPoseSize, 6, Eigen::RowMajor> PlusJacobian(const PoseBlock& pose) {
  Eigen::Matrix<double, kPoseSize, 6, Eigen::RowMajor> plus;
  LeftPoseManifold().PlusJacobian(pose.data(), plus.data());
  return plus;
}

template <typename Functor>
Expansion PerPoint(const std::vector<Functor>& functors, const PoseBlock& pose,
                   const RobustKernel& kernel) {
  constexpr int kRows = Functor::kResidualSize;
  Expansion sum;
  for (const Functor& functor : functors) {
    const std::unique_ptr<ceres::CostFunction> cost(PerPointCost(functor));
    Eigen::Matrix<double, kRows, 1> r;
    Eigen::Matrix<double, kRows, kPoseSize, Eigen::RowMajor> ambient;
    const double* parameters = pose.data();
    double* jacobian = ambient.data();
    cost->Evaluate(&parameters, r.data(), &jacobian);
    const Eigen::Matrix<double, kRows, 6> j = ambient * PlusJacobian(pose);
    const KernelValue<double> rho = EvaluateKernel(kernel, r.squaredNorm());
    sum.cost += rho.rho / 2;
    sum.gradient += rho.slope * j.transpose() * r;
    sum.hessian += rho.slope * j.transpose() * j;
    sum.gradient_terms += rho.slope * j.cwiseAbs().transpose() * r.cwiseAbs();
  }
  sum.hessian_terms = sum.hessian.diagonal();
  return sum;
}

template <typename S, typename Functor>
std::unique_ptr<ReducedBlock> Reduced(const std::vector<Functor>& functors,
                                      const RobustKernel& kernel) {
  return std::make_unique<ReducedBatch<Functor, S>>(
      Definition<Functor>(), BatchData<Functor, S>::FromFunctors(functors), kernel);
}

template <typename S, typename Functor>
Expansion FromBatch(const std::vector<Functor>& functors, const PoseBlock& pose,
                    const RobustKernel& kernel, double relative_tolerance) {
  const auto cost = Reduced<S>(functors, kernel);
  Eigen::Matrix<double, 7, 1> r;
  Eigen::Matrix<double, 7, kPoseSize, Eigen::RowMajor> ambient;
  const double* parameters = pose.data();
  double* jacobian = ambient.data();
  EXPECT_TRUE(cost->Evaluate(&parameters, r.data(), &jacobian));
  const Eigen::Matrix<double, 7, 6> j = ambient * PlusJacobian(pose);
  Expansion sum;
  sum.cost = r.squaredNorm() / 2;
  sum.gradient = j.transpose() * r;
  sum.hessian = j.transpose() * j;
  Eigen::Matrix<double, 7, 1> residuals_only;
  EXPECT_TRUE(cost->Evaluate(&parameters, residuals_only.data(), nullptr));
  EXPECT_NEAR(residuals_only.squaredNorm() / 2, sum.cost, relative_tolerance * sum.cost);
  return sum;
}

template <typename S, typename Functor>
void ExpectSameExpansion(const std::vector<int>& counts, double relative_tolerance) {
  std::mt19937_64 rng(1);
  for (const int count : counts) {
    const Rigid3d truth = RandomPose(0.2, 0.3, &rng);
    const auto functors = RandomFunctors<Functor>(count, truth, 0.01, count);
    Vector6 off;
    off << 0.001, -0.002, 0.0005, 0.002, -0.001, 0.001;
    const PoseBlock pose = AsBlock(LeftIncrement<double>(off, truth));
    for (const auto type : kKernels) {
      const RobustKernel kernel{type, 3};
      const Expansion expected = PerPoint(functors, pose, kernel);
      const Expansion actual = FromBatch<S>(functors, pose, kernel, relative_tolerance);
      EXPECT_NEAR(actual.cost, expected.cost, relative_tolerance * expected.cost);
      for (int i = 0; i < 6; ++i) {
        EXPECT_NEAR(actual.gradient[i], expected.gradient[i],
                    relative_tolerance * expected.gradient_terms[i])
            << count << " " << static_cast<int>(type) << " " << i;
        for (int k = 0; k < 6; ++k) {
          EXPECT_NEAR(actual.hessian(i, k), expected.hessian(i, k),
                      relative_tolerance *
                          std::sqrt(expected.hessian_terms[i] * expected.hessian_terms[k]));
        }
      }
    }
  }
}

template <typename Functor>
class ReducedBatchOf : public ::testing::Test {};
using AllFunctors =
    ::testing::Types<PointToPoint, PointToPlane, SymmetricPointToPlane, PlaneToPlane, Photometric>;
TYPED_TEST_SUITE(ReducedBatchOf, AllFunctors);

TYPED_TEST(ReducedBatchOf, AgreesWithPerPointProblemInDouble) {
  ExpectSameExpansion<double, TypeParam>({1, 5, 1003}, 1e-9);
}

// Coordinates of 2 m have rounding errors of 1e-7 m, which is 1e-5 of the residuals. Sums are more
// accurate than single points. 1003 points do not fill the last lanes.
TYPED_TEST(ReducedBatchOf, AgreesWithPerPointProblemInFloat) {
  ExpectSameExpansion<float, TypeParam>({1003, 9000}, 1e-5);
}

template <typename S, typename Functor>
Rigid3d SolveReduced(const std::vector<Functor>& functors, const Rigid3d& initial,
                     const RobustKernel& kernel, ceres::Manifold* manifold) {
  PoseBlock pose = AsBlock(initial);
  ceres::Problem problem;
  problem.AddParameterBlock(pose.data(), kPoseSize, manifold);
  problem.AddResidualBlock(Reduced<S>(functors, kernel).release(), nullptr, pose.data());
  const ceres::Solver::Summary summary = Solve(&problem);
  EXPECT_TRUE(summary.IsSolutionUsable()) << summary.FullReport();
  return PoseFromBlock(pose.data());
}

TYPED_TEST(ReducedBatchOf, ReachesTheMinimumOfPerPointProblem) {
  const Rigid3d truth(QuaternionExp<double>({0.1, -0.1, 0.2}), {0.1, 0.2, -0.1});
  const auto functors = RandomFunctors<TypeParam>(2000, truth, 0.01, 3);
  Vector6 off;
  off << 0.01, -0.02, 0.005, 0.02, -0.01, 0.01;
  const Rigid3d initial = LeftIncrement<double>(off, truth);
  const Rigid3d expected = SolvePerPoint(functors, initial, new LeftPoseManifold);
  const RobustKernel none;
  EXPECT_THAT(SolveReduced<double>(functors, initial, none, new LeftPoseManifold),
              RigidNear(expected, 1e-9, 1e-9));
  EXPECT_THAT(SolveReduced<double>(functors, initial, none, new ProductPoseManifold),
              RigidNear(expected, 1e-9, 1e-9));
  EXPECT_THAT(SolveReduced<float>(functors, initial, none, new LeftPoseManifold),
              RigidNear(expected, 1e-6, 1e-6));
}

// A plane does not constrain three directions: the solver keeps the initial values along them.
TEST(ReducedBatch, PlaneDoesNotChangeUnobservableDirections) {
  std::mt19937_64 rng(4);
  std::vector<PointToPlane> functors;
  for (int i = 0; i < 1000; ++i) {
    Eigen::Vector3d p = RandomVector(1, &rng);
    p.z() = 2;
    functors.emplace_back(p, p + Eigen::Vector3d(0, 0, 0.01), Eigen::Vector3d(0, 0, 1), 0.005);
  }
  const Rigid3d solved =
      SolveReduced<double>(functors, Rigid3d(), RobustKernel(), new LeftPoseManifold);
  EXPECT_THAT(solved.translation, VectorNear(Eigen::Vector3d(0, 0, 0.01), 1e-9));
  EXPECT_LT(RotationAngle(solved.rotation), 1e-9);
}

// Evaluate() gives the same result at the prepared pose and at other poses.
TEST(ReducedBatch, PrepareDoesNotChangeResult) {
  const auto functors = RandomFunctors<PointToPlane>(1000, Rigid3d(), 0.01, 5);
  const RobustKernel kernel = {RobustKernelType::kHuber, 1.5};
  const auto prepared = Reduced<float>(functors, kernel), plain = Reduced<float>(functors, kernel);
  const RowSums& sums = prepared->Prepare();
  for (const double x : {0., 0.01}) {
    const PoseBlock pose = AsBlock(Rigid3d(Eigen::Quaterniond::Identity(), {x, 0, 0}));
    const auto evaluated = [&](const ceres::CostFunction& cost) {
      Eigen::Matrix<double, 7, 1> r;
      Eigen::Matrix<double, 7, kPoseSize, Eigen::RowMajor> j;
      const double* parameters = pose.data();
      double* jacobian = j.data();
      EXPECT_TRUE(cost.Evaluate(&parameters, r.data(), &jacobian));
      return Eigen::Matrix<double, 7, 8>((Eigen::Matrix<double, 7, 8>() << r, j).finished());
    };
    EXPECT_EQ(evaluated(*prepared), evaluated(*plain)) << x;
    const double rho = evaluated(*prepared).col(0).squaredNorm();
    if (x == 0) {
      EXPECT_NEAR(sums.rho, rho, 1e-9 * rho);
    } else {
      EXPECT_GT(rho, 1.01 * sums.rho);
    }
  }
}

TEST(ReducedBatchThreads, IsBitwiseIdenticalAtAnyNumberOfThreads) {
  const auto functors = RandomFunctors<PointToPlane>(50000, Rigid3d(), 0.01, 5);
  const auto cost = Reduced<float>(functors, {RobustKernelType::kHuber, 1.5});
  std::vector<Eigen::Matrix<double, 7, 8>> results;
  const PoseBlock pose = AsBlock(Rigid3d());
  for (const int threads : {1, 2, 4}) {
    const ThreadLimit limit(threads);
    Eigen::Matrix<double, 7, 1> r;
    Eigen::Matrix<double, 7, kPoseSize, Eigen::RowMajor> j;
    const double* parameters = pose.data();
    double* jacobian = j.data();
    cost->Evaluate(&parameters, r.data(), &jacobian);
    results.emplace_back();
    results.back() << r, j;
  }
  EXPECT_EQ(results[0], results[1]);
  EXPECT_EQ(results[0], results[2]);
}

}  // namespace
}  // namespace surfit::testing
