#include <ceres/ceres.h>
#include <gmock/gmock.h>

#include <Eigen/QR>
#include <chrono>
#include <cmath>
#include <limits>
#include <random>
#include <thread>

#include "registration/dual_system.h"
#include "registration/global/register_from.h"
#include "registration/random_correspondences.h"
#include "registration/solvers/decompositions.h"
#include "registration/three_planes.h"
#include "surfit/core/options.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/registration/association.h"
#include "surfit/registration/icp.h"
#include "surfit/registration/pose_solver.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

const std::vector<std::string> kClosedForms = {"closed_form_ldlt", "closed_form_lu",
                                               "closed_form_qr"};

// The condition number is about 100 for A and 1e4 for A^T A: 1e4 roundings of 1e-16. The covariance
// of a plane adds a factor of 1e3.
constexpr double kRelativeTolerance = 1e-9;

StepResult Step(const std::string& solver, ResidualType residual, const Correspondences& pairs) {
  PoseSolverOptions options;
  options.name = solver;
  options.residual = residual;
  options.error_model.kernel = {RobustKernelType::kHuber, 0.1};
  return MakePoseSolver(options)->Step(pairs);
}

// Minimises the linearised, weighted cost by pivoted QR, with rows from autodiff.
Vector6d DenseSolution(const Correspondences& c, ResidualType type) {
  std::vector<Eigen::Matrix<double, 1, 7>> rows;
  for (int i = 0; i < c.size; ++i) {
    const std::vector<Jet> residuals = DualResiduals(c, i, type);
    double s = 0;
    for (const Jet& r : residuals) s += c.information[i] * r.a * r.a;
    // Huber: beyond the width, the weight is proportional to 1 / sqrt(s).
    const double slope = s > 0.01 ? 0.1 / std::sqrt(s) : 1;
    for (const Jet& r : residuals) {
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

TEST_P(ClosedFormSolvers, AgreeWithDenseLeastSquares) {
  std::mt19937_64 rng(1);
  for (int i = 0; i < 10; ++i) {
    const Correspondences pairs = RandomCorrespondences(500, 0.1, &rng);
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

// The solvers use the target camera frame, so the world origin has no effect. With points far from
// the origin, the conditioning would be worse.
TEST(ClosedFormSolvers, EigenvaluesDecreaseWithDistanceOfPointsToOrigin) {
  std::mt19937_64 rng_near(4), rng_far(4);
  const auto smallest = [](const Correspondences& pairs) {
    return Step("closed_form_ldlt", ResidualType::kPointToPlane, pairs)
        .observability.eigenvalues[0];
  };
  EXPECT_LT(smallest(RandomCorrespondences(300, 0.1, &rng_far, {100, 0, 3})),
            1e-2 * smallest(RandomCorrespondences(300, 0.1, &rng_near)));
}

TEST(MakePoseSolver, RejectsUnknownNameAndListsKnownNames) {
  PoseSolverOptions options;
  options.residual = ResidualType::kPointToPoint;
  for (const std::string& name : PoseSolverNames()) {
    options.name = name;
    EXPECT_NE(MakePoseSolver(options), nullptr);
  }
  options.name = "magic";
  ExpectInputError([&] { MakePoseSolver(options); },
                   Names("solver", "magic", "closed_form_ldlt", "closed_form_lu", "closed_form_qr",
                         "svd", "ceres", "ceres_per_point", "tiny"));
}

TEST(MakePoseSolver, RejectsSvdWithOtherResiduals) {
  PoseSolverOptions options;
  options.name = "svd";
  for (const std::string& residual : ResidualTypeNames()) {
    options.residual = ResidualTypeFromName(residual);
    if (options.residual == ResidualType::kPointToPoint) continue;
    ExpectInputError([&] { MakePoseSolver(options); },
                     Names("residual", residual, "point_to_point", "svd"));
  }
}

StepResult StepOf(const std::string& solver, ResidualType residual, const Correspondences& pairs) {
  PoseSolverOptions options;
  options.name = solver;
  options.residual = residual;
  return MakePoseSolver(options)->Step(pairs);
}

// Two views of a corner. The residuals of some points are in the tail of the kernel.
struct CornerViews {
  FrameLevel target = RenderCorner(PoseBeforeTheCorner());
  FrameLevel source = RenderCorner(PoseBeforeTheCorner());
  Rigid3d pose{QuaternionExp<double>({0.01, -0.004, 0.006}), {0.012, -0.008, 0.01}};
  ProjectiveAssociation association{source, target, AssociationGates(), ErrorModel(),
                                    NeededNormals::kBoth};

  StepResult Step(const std::string& solver, ResidualType residual,
                  const std::string& linear_solver = "dense_qr") const {
    PoseSolverOptions options;
    options.name = solver;
    options.linear_solver = linear_solver;
    options.residual = residual;
    return MakePoseSolver(options)->Step(association, pose);
  }
};

// A term of a gradient in single precision has a relative rounding error of 1e-7. The sum over 1e4
// points has an error of 1e-9 of the absolute terms. Weakly constrained directions amplify the
// error.
constexpr double kTolerance = 1e-7;

class CeresSolvers : public ::testing::TestWithParam<std::string> {
 protected:
  const ResidualType residual_ = ResidualTypeFromName(GetParam());
  const CornerViews corner_;
};

TEST_P(CeresSolvers, ReachSameMinimum) {
  const Vector6d reduced = corner_.Step("ceres", residual_).increment;
  EXPECT_GT(reduced.norm(), 0.002);
  EXPECT_THAT(corner_.Step("tiny", residual_).increment, VectorNear(reduced, kTolerance));
  for (const std::string& linear_solver : LinearSolverNames()) {
    EXPECT_THAT(corner_.Step("ceres_per_point", residual_, linear_solver).increment,
                VectorNear(reduced, kTolerance))
        << linear_solver;
  }
}

// Reweighted Gauss-Newton steps with constant correspondences converge to the same minimum as
// Levenberg-Marquardt, so a further closed-form step is zero. The covariances of planes rotate with
// the increment between solves.
TEST_P(CeresSolvers, MinimiseSameCostAsClosedForm) {
  const Vector6d increment = corner_.Step("ceres", residual_).increment;
  const Correspondences pairs = AsDouble(corner_.association.Collect(corner_.pose));
  const Correspondences moved = Moved(pairs, LeftIncrement<double>(increment, Rigid3d()));
  const Vector6d again = StepOf("closed_form_ldlt", residual_, moved).increment;
  const bool held = residual_ == ResidualType::kPlaneToPlane;
  EXPECT_LT(again.norm(), held ? 0.05 * increment.norm() : 10 * kTolerance);
}

TEST_P(CeresSolvers, ReportSystemBeforeStep) {
  const StepResult ceres = corner_.Step("ceres", residual_);
  const StepResult tiny = corner_.Step("tiny", residual_);
  EXPECT_EQ(ceres.system.pair_count, tiny.system.pair_count);
  EXPECT_EQ(ceres.system.inlier_count, tiny.system.inlier_count);
  EXPECT_EQ(ceres.system.hessian, tiny.system.hessian);
  EXPECT_EQ(ceres.observability.eigenvalues, tiny.observability.eigenvalues);
}

class SlowAssociation final : public Association {
 public:
  explicit SlowAssociation(const Association& inner) : inner_(inner) {}
  int source_count() const override { return inner_.source_count(); }
  int block_count() const override { return inner_.block_count(); }
  int block_capacity() const override { return inner_.block_capacity(); }
  std::unique_ptr<const PairFinder> At(const Rigid3d& target_from_source) const override {
    std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(kTime_ms));
    return inner_.At(target_from_source);
  }

  static constexpr double kTime_ms = 20;

 private:
  const Association& inner_;
};

TEST(SolveReport, TimesOfAllSolversIncludeTheAssociation) {
  const CornerViews corner;
  const SlowAssociation slow(corner.association);
  for (const std::string& name : PoseSolverNames()) {
    PoseSolverOptions options;
    options.name = name;
    options.residual = ResidualType::kPointToPoint;
    const SolveReport report = MakePoseSolver(options)->Step(slow, corner.pose).report;
    EXPECT_GE(report.linearize_ms, SlowAssociation::kTime_ms) << name;
    EXPECT_GE(report.solve_ms, report.linearize_ms) << name;
  }
}

// Ceres ends with a point that it does not accept. With a large tolerance, its cost can be larger.
TEST(CeresConvergence, ReturnsThePointOfLeastCost) {
  std::mt19937_64 rng(3);
  for (const char* solver : {"ceres", "ceres_per_point"}) {
    PoseSolverOptions options;
    options.name = solver;
    options.residual = ResidualType::kPointToPlane;
    options.error_model.kernel = {RobustKernelType::kTukey, 0.3};
    options.min_relative_cost_change = 0.9;
    for (int trial = 0; trial < 50; ++trial) {
      const Correspondences pairs = RandomCorrespondences(10, 0.3, &rng);
      const auto pose_solver = MakePoseSolver(options);
      const StepResult step = pose_solver->Step(pairs);
      const Rigid3d motion = LeftIncrement<double>(step.increment, Rigid3d());
      const double cost = pose_solver->Step(Moved(pairs, motion)).report.costs.front();
      EXPECT_LE(cost, (1 + 1e-9) * step.report.costs.back()) << solver << ' ' << trial;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Residuals, CeresSolvers, ::testing::ValuesIn(ResidualTypeNames()),
                         [](const auto& instance) { return instance.param; });

TEST(MakePoseSolver, RejectsUnknownLinearSolverAndListsKnownNames) {
  PoseSolverOptions solver_options;
  solver_options.name = "ceres_per_point";
  solver_options.linear_solver = "magic";
  ExpectInputError([&] { MakePoseSolver(solver_options); },
                   Names("linear_solver", "magic", "dense_qr", "dense_normal_cholesky",
                         "sparse_normal_cholesky"));
  IcpOptions options;
  options.linear_solver = "magic";
  ExpectInputError([&] { Validate(options); }, Names("linear_solver", "magic"));
}

Matrix6d RandomCovariance() {
  std::mt19937_64 generator(1);
  std::normal_distribution<double> normal;
  Matrix6d factor;
  for (double& value : factor.reshaped()) value = 1e-3 * normal(generator);
  return factor * factor.transpose() + 1e-7 * Matrix6d::Identity();
}

TEST(LargestSigma, IsSigmaOfWorstDirection) {
  const Eigen::Matrix3d turn = QuaternionExp<double>({0.3, -0.2, 0.5}).toRotationMatrix();
  const Eigen::Matrix3d diagonal = Eigen::Vector3d(1e-4, 9e-4, 4e-4).asDiagonal();
  EXPECT_NEAR(LargestSigma(turn * diagonal * turn.transpose()), 0.03, 1e-12);
}

// The weakest direction is a translation along y. For near points it is a rotation, which moves
// near points less.
TEST(WeakestIncrement, MovesPointsByOneMetreAlongWeakestDirection) {
  Matrix6d information = Matrix6d::Identity();
  information(4, 4) = 0.01;
  EXPECT_NEAR(std::abs((*WeakestIncrement(information, 2))[4]), 1, 0.2);
  information = Matrix6d::Identity();
  information(1, 1) = 0.04;
  const Vector6d turn = *WeakestIncrement(information, 2);
  EXPECT_NEAR(std::abs(turn[1]), 0.5, 1e-12);
}

TEST(Decompositions, HaveNoResultForMatricesThatAreNotFinite) {
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    Matrix6d matrix = Matrix6d::Identity();
    matrix(2, 3) = matrix(3, 2) = bad;
    EXPECT_FALSE(EigenvaluesOf(matrix));
    EXPECT_FALSE(EigenOf(matrix, Matrix6d::Identity()));
    EXPECT_FALSE(EigenOf(Matrix6d::Identity(), matrix));
    EXPECT_FALSE(WeakestIncrement(matrix, 2));
    EXPECT_EQ(LargestSigma(matrix.block<3, 3>(1, 1)), std::numeric_limits<double>::infinity());
  }
}

TEST(EigenOf, HasNoResultForIndefiniteMetric) {
  Matrix6d metric = Matrix6d::Identity();
  metric(5, 5) = -1;
  EXPECT_FALSE(EigenOf(Matrix6d::Identity(), metric));
}

TEST(Observe, HoldsNoDirectionOfSystemThatIsNotFinite) {
  NormalSystem system;
  system.hessian = Matrix6d::Identity();
  system.weight_sum = 1;
  system.point_product_sum = Eigen::Matrix3d::Identity();
  ASSERT_EQ(Observe(system, {}).degenerate_count, 0);
  EXPECT_GT(ConservativeInformation(system, 1).norm(), 0);
  system.hessian(1, 1) = std::nan("");
  const Observability observability = Observe(system, {});
  EXPECT_EQ(observability.degenerate_count, 6);
  EXPECT_EQ(observability.Held(Vector6d::Ones()), Vector6d::Zero());
  EXPECT_EQ(ConservativeInformation(system, 1), Matrix6d::Zero());
}

TEST(RealisticCovariance, IsLargerThanRegistrationCovariance) {
  const Matrix6d covariance = RandomCovariance();
  const Matrix6d sure = RealisticCovariance(covariance, 0, 0);
  const Matrix6d doubtful = RealisticCovariance(covariance, 0.003, 0.01);
  for (int i = 0; i < 6; ++i) {
    EXPECT_GT(sure(i, i), covariance(i, i));
    EXPECT_NEAR(doubtful(i, i) - sure(i, i), i < 3 ? 9e-6 : 1e-4, 1e-15);
  }
}

TEST(SymmetricInverse, IsSymmetric) {
  const Matrix6d covariance = RandomCovariance();
  const Matrix6d information = SymmetricInverse(covariance);
  EXPECT_EQ(information, Matrix6d(information.transpose()));
  EXPECT_LT((information * covariance - Matrix6d::Identity()).norm(), 1e-9);
}

}  // namespace
}  // namespace surfit::testing
