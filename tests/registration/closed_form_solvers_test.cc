#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include <Eigen/QR>

#include "registration/random_correspondences.h"
#include "surfit/registration/pose_solver.h"
#include "testing/expect_input_error.h"
#include "testing/matchers.h"

namespace surfit {
namespace {

using testing::VectorNear;

constexpr double kMinEigenvalue = 1e-6;

// The condition number of these data is about 100 in A, 1e4 in A^T A: 1e4 roundings of 1e-16.
constexpr double kRelativeTolerance = 1e-9;

// Minimises the linearised cost by pivoted QR of the weighted N x 6 matrix, its rows written out by
// hand.
Vector6d DenseSolution(const Correspondences& c) {
  Eigen::MatrixXd a(c.size(), 6);
  Eigen::VectorXd b(c.size());
  for (std::size_t i = 0; i < c.size(); ++i) {
    const double s = std::sqrt(c.weight[i]);
    a.row(i) << s * (c.py[i] * c.nz[i] - c.pz[i] * c.ny[i]),
        s * (c.pz[i] * c.nx[i] - c.px[i] * c.nz[i]), s * (c.px[i] * c.ny[i] - c.py[i] * c.nx[i]),
        s * c.nx[i], s * c.ny[i], s * c.nz[i];
    b[i] = s * (c.nx[i] * (c.qx[i] - c.px[i]) + c.ny[i] * (c.qy[i] - c.py[i]) +
                c.nz[i] * (c.qz[i] - c.pz[i]));
  }
  return a.colPivHouseholderQr().solve(b);
}

struct NamedSolution {
  std::string name;
  StepResult step;
};

std::vector<NamedSolution> AllSolutions(const Correspondences& pairs) {
  const NormalSystem system = BuildNormalSystem(pairs);
  return {{"ldlt", SolveLdlt(system, kMinEigenvalue)},
          {"lu", SolveLu(system, kMinEigenvalue)},
          {"qr", SolveQr(pairs, kMinEigenvalue)}};
}

TEST(ClosedFormSolvers, AllGiveTheLeastSquaresIncrement) {
  std::mt19937_64 rng(1);
  for (int i = 0; i < 20; ++i) {
    const Correspondences pairs = testing::RandomCorrespondences(500, 0.1, &rng);
    const Vector6d expected = DenseSolution(pairs);
    for (const NamedSolution& solution : AllSolutions(pairs)) {
      EXPECT_FALSE(solution.step.singular);
      EXPECT_GT(solution.step.smallest_eigenvalue, kMinEigenvalue);
      EXPECT_EQ(solution.step.system.pair_count, 500);
      EXPECT_THAT(solution.step.increment,
                  VectorNear(expected, kRelativeTolerance * expected.norm()))
          << solution.name;
    }
  }
}

// One linear residual sqrt(w) (a . x - b), differentiated automatically.
struct LinearisedResidual {
  template <typename T>
  bool operator()(const T* x, T* residual) const {
    const Eigen::Map<const Eigen::Matrix<T, 3, 1>> w(x), v(x + 3);
    const Eigen::Matrix<T, 3, 1> moved = p.cast<T>() + w.cross(p.cast<T>().eval()) + v;
    *residual = root_weight * n.cast<T>().dot(Eigen::Matrix<T, 3, 1>(moved - q.cast<T>()));
    return true;
  }
  Eigen::Vector3d p, q, n;
  double root_weight;
};

TEST(ClosedFormSolvers, AgreeWithCeres) {
  std::mt19937_64 rng(2);
  const Correspondences pairs = testing::RandomCorrespondences(300, 0.1, &rng);
  Vector6d x = Vector6d::Zero();
  ceres::Problem problem;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<LinearisedResidual, 1, 6>(
            new LinearisedResidual{testing::PointOf(pairs, i), testing::TargetOf(pairs, i),
                                   testing::NormalOf(pairs, i), std::sqrt(pairs.weight[i])}),
        nullptr, x.data());
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.initial_trust_region_radius = 1e16;  // Gauss-Newton
  options.max_trust_region_radius = 1e32;
  options.function_tolerance = options.gradient_tolerance = options.parameter_tolerance = 1e-16;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  for (const NamedSolution& solution : AllSolutions(pairs)) {
    EXPECT_THAT(solution.step.increment, VectorNear(x, kRelativeTolerance * x.norm()))
        << solution.name;
  }
}

// Pairs that fit exactly after a small motion: the increment is that motion, up to the square of
// the angle that linearisation leaves out.
TEST(ClosedFormSolvers, FindASmallMotion) {
  std::mt19937_64 rng(3);
  const Rigid3d motion = testing::RandomPose(1e-4, 1e-3, &rng);
  Correspondences pairs = testing::RandomCorrespondences(500, 0, &rng);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Eigen::Vector3d q = motion * testing::PointOf(pairs, i);
    pairs.qx[i] = q.x(), pairs.qy[i] = q.y(), pairs.qz[i] = q.z();
  }
  for (const NamedSolution& solution : AllSolutions(pairs)) {
    const Rigid3d found = LeftIncrement(solution.step.increment, Rigid3d());
    // |w|^2 |p| / 2 = 3e-8 / 2 * 5 m at most, amplified by the condition number of A, about 10.
    EXPECT_THAT(found, testing::RigidNear(motion, 1e-6, 1e-6)) << solution.name;
  }
}

// What the solvers see is in the target camera's frame, so that moving world, map and poses changes
// nothing; were the points themselves far from the origin, conditioning would suffer.
TEST(ClosedFormSolvers, EigenvaluesFallWithTheDistanceOfTheOriginThatWeDoNotUse) {
  std::mt19937_64 rng_near(4), rng_far(4);
  const Correspondences near = testing::RandomCorrespondences(300, 0.1, &rng_near);
  const Correspondences far = testing::RandomCorrespondences(300, 0.1, &rng_far, {100, 0, 3});
  EXPECT_LT(BuildNormalSystem(far).ScaledEigenvalues()[0],
            1e-2 * BuildNormalSystem(near).ScaledEigenvalues()[0]);
}

TEST(MakePoseSolver, KnowsItsNamesAndListsThemForAnother) {
  for (const std::string& name : PoseSolverNames()) {
    EXPECT_NE(MakePoseSolver({name, "dense_qr", kMinEigenvalue}), nullptr);
  }
  testing::ExpectInputError(
      [] { MakePoseSolver({"svd", "dense_qr", kMinEigenvalue}); },
      ::testing::StrEq("solver is 'svd', must be one of: closed_form_ldlt, closed_form_lu, "
                       "closed_form_qr, ceres, ceres_per_point, tiny"));
}

}  // namespace
}  // namespace surfit
