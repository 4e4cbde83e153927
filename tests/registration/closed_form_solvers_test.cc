#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include <Eigen/QR>

#include "registration/dual_system.h"
#include "registration/random_correspondences.h"
#include "surfit/registration/pose_solver.h"
#include "testing/expect_input_error.h"
#include "testing/matchers.h"

namespace surfit {
namespace {

using testing::VectorNear;

const std::vector<std::string> kClosedForms = {"closed_form_ldlt", "closed_form_lu",
                                               "closed_form_qr"};

// The condition number of these data is about 100 in A, 1e4 in A^T A: 1e4 roundings of 1e-16. A
// plane's covariance has one of 1e3 more.
constexpr double kRelativeTolerance = 1e-9;

StepResult Step(const std::string& solver, ResidualType residual, const Correspondences& pairs) {
  PoseSolverOptions options;
  options.name = solver;
  options.residual = residual;
  options.error_model.kernel = {RobustKernelType::kHuber, 0.1};
  return MakePoseSolver(options)->Step(pairs);
}

// Minimises the linearised, weighted cost by pivoted QR; rows by automatic differentiation.
Vector6d DenseSolution(const Correspondences& c, ResidualType type) {
  std::vector<Eigen::Matrix<double, 1, 7>> rows;
  for (int i = 0; i < c.size; ++i) {
    const std::vector<testing::Jet> residuals = testing::DualResiduals(c, i, type);
    double s = 0;
    for (const testing::Jet& r : residuals) s += c.information[i] * r.a * r.a;
    // Huber: sqrt(s) beyond the width has its weight in inverse proportion.
    const double slope = s > 0.01 ? 0.1 / std::sqrt(s) : 1;
    for (const testing::Jet& r : residuals) {
      rows.emplace_back();
      rows.back() << r.v.transpose(), -r.a;
      rows.back() *= std::sqrt(slope * c.information[i]);
    }
  }
  Eigen::MatrixXd a(rows.size(), 7);
  for (std::size_t k = 0; k < rows.size(); ++k) a.row(k) = rows[k];
  return a.leftCols<6>().colPivHouseholderQr().solve(a.col(6));
}

class ClosedFormSolvers : public ::testing::TestWithParam<ResidualType> {};

TEST_P(ClosedFormSolvers, AllGiveTheLeastSquaresIncrement) {
  std::mt19937_64 rng(1);
  for (int i = 0; i < 10; ++i) {
    const Correspondences pairs = testing::RandomCorrespondences(500, 0.1, &rng);
    const Vector6d expected = DenseSolution(pairs, GetParam());
    for (const std::string& solver : kClosedForms) {
      const StepResult step = Step(solver, GetParam(), pairs);
      EXPECT_FALSE(step.observability.Degenerate());
      EXPECT_EQ(step.system.pair_count, 500);
      EXPECT_THAT(step.increment, VectorNear(expected, kRelativeTolerance * expected.norm()))
          << solver;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Residuals, ClosedFormSolvers,
                         ::testing::Values(ResidualType::kPointToPoint, ResidualType::kPointToPlane,
                                           ResidualType::kSymmetricPointToPlane,
                                           ResidualType::kPlaneToPlane),
                         [](const auto& instance) { return ToString(instance.param); });

// What the solvers see is in the target camera's frame, so that moving world, map and poses changes
// nothing; were the points themselves far from the origin, conditioning would suffer.
TEST(ClosedFormSolvers, EigenvaluesFallWithTheDistanceOfTheOriginThatWeDoNotUse) {
  std::mt19937_64 rng_near(4), rng_far(4);
  const auto smallest = [](const Correspondences& pairs) {
    return Step("closed_form_ldlt", ResidualType::kPointToPlane, pairs)
        .observability.eigenvalues[0];
  };
  EXPECT_LT(smallest(testing::RandomCorrespondences(300, 0.1, &rng_far, {100, 0, 3})),
            1e-2 * smallest(testing::RandomCorrespondences(300, 0.1, &rng_near)));
}

TEST(MakePoseSolver, KnowsItsNamesAndListsThemForAnother) {
  PoseSolverOptions options;
  options.residual = ResidualType::kPointToPoint;
  for (const std::string& name : PoseSolverNames()) {
    options.name = name;
    EXPECT_NE(MakePoseSolver(options), nullptr);
  }
  options.name = "magic";
  testing::ExpectInputError(
      [&] { MakePoseSolver(options); },
      ::testing::StrEq("solver is 'magic', must be one of: closed_form_ldlt, closed_form_lu, "
                       "closed_form_qr, svd, ceres, ceres_per_point, tiny"));
}

TEST(MakePoseSolver, SvdTakesPointsOnly) {
  PoseSolverOptions options;
  options.name = "svd";
  for (const std::string& residual : ResidualTypeNames()) {
    options.residual = ResidualTypeFromName(residual);
    if (options.residual == ResidualType::kPointToPoint) continue;
    testing::ExpectInputError(
        [&] { MakePoseSolver(options); },
        ::testing::StrEq("residual is '" + residual +
                         "', must be point_to_point with solver svd; all other solvers take every "
                         "residual"));
  }
}

}  // namespace
}  // namespace surfit
