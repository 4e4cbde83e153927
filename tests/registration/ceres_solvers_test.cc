#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "registration/random_correspondences.h"
#include "registration/three_planes.h"
#include "surfit/core/options.h"
#include "surfit/registration/association.h"
#include "surfit/registration/icp.h"
#include "surfit/registration/pose_solver.h"
#include "testing/expect_input_error.h"
#include "testing/matchers.h"

namespace surfit {
namespace {

using testing::ExpectInputError;
using testing::VectorNear;

StepResult StepOf(const std::string& solver, ResidualType residual, const Correspondences& pairs) {
  PoseSolverOptions options;
  options.name = solver;
  options.residual = residual;
  return MakePoseSolver(options)->Step(pairs);
}

// Two views of a corner, a step apart that the kernel calls large for some of the points.
struct CornerViews {
  FrameLevel target = testing::RenderCorner(testing::PoseBeforeTheCorner());
  FrameLevel source = testing::RenderCorner(testing::PoseBeforeTheCorner());
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

// A term of a single precision gradient rounds by 1e-7 of itself, the sum over 1e4 points by 1e-9
// of their magnitudes; what the pairs hold weakly magnifies that.
constexpr double kTolerance = 1e-7;

class CeresSolvers : public ::testing::TestWithParam<std::string> {
 protected:
  const ResidualType residual_ = ResidualTypeFromName(GetParam());
  const CornerViews corner_;
};

TEST_P(CeresSolvers, AllReachTheSameMinimum) {
  const Vector6d reduced = corner_.Step("ceres", residual_).increment;
  EXPECT_GT(reduced.norm(), 0.002);
  EXPECT_THAT(corner_.Step("tiny", residual_).increment, VectorNear(reduced, kTolerance));
  for (const std::string& linear_solver : LinearSolverNames()) {
    EXPECT_THAT(corner_.Step("ceres_per_point", residual_, linear_solver).increment,
                VectorNear(reduced, kTolerance))
        << linear_solver;
  }
}

// Gauss-Newton steps on fixed pairs, reweighted, end where Levenberg-Marquardt does: one more step
// of the closed form from there is zero. The planes' covariances are not held between solves, and
// so turn with the increment.
TEST_P(CeresSolvers, MinimiseWhatTheClosedFormMinimises) {
  const Vector6d increment = corner_.Step("ceres", residual_).increment;
  const Correspondences pairs = testing::AsDouble(corner_.association.Collect(corner_.pose));
  const Correspondences moved = Moved(pairs, LeftIncrement<double>(increment, Rigid3d()));
  const Vector6d again = StepOf("closed_form_ldlt", residual_, moved).increment;
  const bool held = residual_ == ResidualType::kPlaneToPlane;
  EXPECT_LT(again.norm(), held ? 0.05 * increment.norm() : 10 * kTolerance);
}

TEST_P(CeresSolvers, DescribeTheSystemBeforeTheStep) {
  const StepResult ceres = corner_.Step("ceres", residual_);
  const StepResult tiny = corner_.Step("tiny", residual_);
  EXPECT_EQ(ceres.system.pair_count, tiny.system.pair_count);
  EXPECT_EQ(ceres.system.inlier_count, tiny.system.inlier_count);
  EXPECT_EQ(ceres.system.hessian, tiny.system.hessian);
  EXPECT_EQ(ceres.observability.eigenvalues, tiny.observability.eigenvalues);
}

INSTANTIATE_TEST_SUITE_P(Residuals, CeresSolvers, ::testing::ValuesIn(ResidualTypeNames()),
                         [](const auto& instance) { return instance.param; });

TEST(MakePoseSolver, UnknownLinearSolversListTheKnown) {
  PoseSolverOptions solver_options;
  solver_options.name = "ceres_per_point";
  solver_options.linear_solver = "magic";
  ExpectInputError([&] { MakePoseSolver(solver_options); },
                   ::testing::StrEq("linear_solver is 'magic', must be one of: dense_qr, "
                                    "dense_normal_cholesky, sparse_normal_cholesky"));
  IcpOptions options;
  options.linear_solver = "magic";
  ExpectInputError([&] { Validate(options); }, ::testing::HasSubstr("linear_solver is 'magic'"));
}

}  // namespace
}  // namespace surfit
