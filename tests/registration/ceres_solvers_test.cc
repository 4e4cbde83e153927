#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "registration/three_planes.h"
#include "surfit/registration/icp.h"
#include "surfit/registration/pose_solver.h"
#include "testing/expect_input_error.h"
#include "testing/matchers.h"

namespace surfit {
namespace {

using testing::ExpectInputError;
using testing::VectorNear;

// Two views of a corner, a step apart that the kernel calls large for some of the points.
struct Corner {
  FrameLevel target = testing::RenderCorner(testing::PoseBeforeTheCorner());
  FrameLevel source = testing::RenderCorner(testing::PoseBeforeTheCorner());
  Rigid3d pose{QuaternionExp<double>({0.01, -0.004, 0.006}), {0.012, -0.008, 0.01}};
  AssociationGates gates;
  ErrorModel error_model;

  ProjectiveAssociation Association() const { return {source, target, gates, error_model}; }
  StepResult Step(const std::string& solver, const std::string& linear_solver = "dense_qr") const {
    return MakePoseSolver({solver, linear_solver, 1e-6})->Step(Association(), pose);
  }
};

// With single precision sums the minimum is where the gradient's rounding allows: 1e-6 (see
// ReducedBatch).
constexpr double kTolerance = 1e-6;

TEST(CeresSolvers, AllReachTheSameMinimum) {
  const Corner corner;
  const Vector6d reduced = corner.Step("ceres").increment;
  EXPECT_GT(reduced.norm(), 0.01);
  EXPECT_THAT(corner.Step("tiny").increment, VectorNear(reduced, kTolerance));
  for (const std::string& linear_solver : LinearSolverNames()) {
    EXPECT_THAT(corner.Step("ceres_per_point", linear_solver).increment,
                VectorNear(reduced, kTolerance))
        << linear_solver;
  }
}

// Gauss-Newton steps on fixed pairs, reweighted, end where Levenberg-Marquardt does: one more step
// of the closed form from there is zero.
TEST(CeresSolvers, MinimiseWhatTheClosedFormMinimises) {
  const Corner corner;
  const Vector6d increment = corner.Step("ceres").increment;
  // The same pairs after the increment, weights and rows anew.
  Correspondences pairs = corner.Association().Collect(corner.pose);
  const Rigid3d step = LeftIncrement<double>(increment, Rigid3d());
  const double k2 = corner.error_model.kernel_width * corner.error_model.kernel_width;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Eigen::Vector3d p(pairs.px[i], pairs.py[i], pairs.pz[i]);
    const Eigen::Vector3d q(pairs.qx[i], pairs.qy[i], pairs.qz[i]);
    const Eigen::Vector3d n(pairs.nx[i], pairs.ny[i], pairs.nz[i]);
    const double variance = std::pow(corner.error_model.Sigma((corner.pose.Inverse() * p).z()), 2);
    const Eigen::Vector3d moved = step * p;
    const double kernel = 1 + std::pow(n.dot(moved - q), 2) / variance / k2;
    pairs.weight[i] = 1 / (variance * kernel * kernel);
    pairs.px[i] = moved.x(), pairs.py[i] = moved.y(), pairs.pz[i] = moved.z();
  }
  const StepResult again = SolveLdlt(BuildNormalSystem(pairs), 1e-6);
  EXPECT_LT(again.increment.norm(), 10 * kTolerance);
  EXPECT_GT(corner.Step("closed_form_ldlt").increment.norm(), 0.01);
}

TEST(CeresSolvers, DescribeTheSystemBeforeTheStep) {
  const Corner corner;
  const StepResult ceres = corner.Step("ceres"), closed = corner.Step("closed_form_ldlt");
  EXPECT_EQ(ceres.system.pair_count, closed.system.pair_count);
  EXPECT_EQ(ceres.system.inlier_count, closed.system.inlier_count);
  EXPECT_EQ(ceres.system.weighted_square_sum, closed.system.weighted_square_sum);
  EXPECT_EQ(ceres.system.hessian, closed.system.hessian);
  EXPECT_EQ(ceres.smallest_eigenvalue, closed.smallest_eigenvalue);
}

TEST(CeresSolvers, UnknownLinearSolversListTheKnown) {
  ExpectInputError(
      [] {
        MakePoseSolver({"ceres_per_point", "magic", 1e-6});
      },
      ::testing::StrEq("linear_solver is 'magic', must be one of: dense_qr, "
                       "dense_normal_cholesky, sparse_normal_cholesky"));
  IcpOptions options;
  options.linear_solver = "magic";
  ExpectInputError([&] { options.Validate(); }, ::testing::HasSubstr("linear_solver is 'magic'"));
}

}  // namespace
}  // namespace surfit
