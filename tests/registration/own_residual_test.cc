#include "cost_functions/own_residual.h"

#include <gtest/gtest.h>

#include "cost_functions/point_to_plane.h"
#include "cost_functions/point_to_point.h"
#include "cost_functions/symmetric_point_to_plane.h"
#include "registration/icp/icp_level.h"
#include "registration/random_correspondences.h"
#include "surfit/registration/pose_solver.h"
#include "testing/matchers.h"
#include "testing/threads.h"

namespace surfit::testing {
namespace {

// Distance to a line: a residual of two rows that is not built in.
struct AcrossAnAxis : PointFunctor<AcrossAnAxis, 7, 2> {
  template <typename T, typename D>
  void AtMovedPoint(const T* y, const D* d, T* residuals) const {
    residuals[0] = (y[0] - d[3]) * d[6];
    residuals[1] = (y[1] - d[4]) * d[6];
  }
};

void RegisterThem() {
  static const bool once = [] {
    RegisterResidual<PointToPoint>("my_point_to_point");
    RegisterResidual<PointToPlane>("my_point_to_plane");
    RegisterResidual<SymmetricPointToPlane>("my_symmetric_point_to_plane");
    RegisterResidual<AcrossAnAxis>("across_an_axis");
    return true;
  }();
  EXPECT_TRUE(once);
}

class OwnResidualOf : public ::testing::TestWithParam<const char*> {
 protected:
  static void SetUpTestSuite() { RegisterThem(); }

  const std::string name_ = GetParam();
  const ResidualType ours_ = ResidualTypeFromName(name_),
                     own_ = ResidualTypeFromName("my_" + name_);
  std::mt19937_64 rng_{3};
  const Correspondences pairs_ = RandomCorrespondences(5003, 0.05, &rng_);
};

// Autodiff of the registered residual agrees with the closed form, up to rounding.
template <typename S>
void ExpectSameSystem(const Pairs<S>& pairs, ResidualType own, ResidualType ours,
                      double tolerance) {
  const RobustKernel kernel = {RobustKernelType::kGemanMcClure, 0.05};
  const NormalSystem a = Linearize(pairs, own, kernel), b = Linearize(pairs, ours, kernel);
  EXPECT_LT((a.hessian - b.hessian).norm(), tolerance * b.hessian.norm());
  EXPECT_LT((a.right_side - b.right_side).norm(), tolerance * b.hessian.norm());
  EXPECT_NEAR(a.cost, b.cost, tolerance * b.cost);
  EXPECT_NEAR(a.weight_sum, b.weight_sum, tolerance * b.weight_sum);
  EXPECT_EQ(a.row_count, b.row_count);
  EXPECT_EQ(a.normal_ratio, b.normal_ratio);
}

TEST_P(OwnResidualOf, AgreesWithBuiltInResidual) {
  EXPECT_EQ(ToString(own_), "my_" + name_);
  EXPECT_EQ(NormalsNeededBy(own_), NormalsNeededBy(ours_));
  ExpectSameSystem(pairs_, own_, ours_, 1e-12);
  ExpectSameSystem(Rounded<float>(pairs_), own_, ours_, 1e-5);
}

TEST_P(OwnResidualOf, StepAgreesWithBuiltInResidualForEachSolver) {
  for (const std::string& solver : PoseSolverNames()) {
    if (solver == "svd") continue;
    PoseSolverOptions options;
    options.name = solver;
    options.residual = own_;
    options.error_model.kernel = {RobustKernelType::kHuber, 0.1};
    const Vector6d own = MakePoseSolver(options)->Step(pairs_).increment;
    options.residual = ours_;
    const Vector6d ours = MakePoseSolver(options)->Step(pairs_).increment;
    EXPECT_THAT(own, VectorNear(ours, 1e-9)) << solver;
    EXPECT_GT(own.norm(), 1e-6);
  }
}

TEST_P(OwnResidualOf, IsTheSameAtAnyNumberOfThreads) {
  const auto systems = AtThreads({1, 3}, [&] {
    return Matrix6d(Linearize(Rounded<float>(pairs_), own_, RobustKernel()).hessian);
  });
  EXPECT_EQ(systems[0], systems[1]);
}

INSTANTIATE_TEST_SUITE_P(Functors, OwnResidualOf,
                         ::testing::Values("point_to_point", "point_to_plane",
                                           "symmetric_point_to_plane"),
                         [](const auto& test) { return std::string(test.param); });

// All solvers find the observable part of a small motion, up to second order of the step.
TEST(OwnResidual, WithTwoRowsIsMinimised) {
  RegisterThem();
  std::mt19937_64 rng(5);
  const Rigid3d motion = RandomPose(0.001, 0.01, &rng);
  const Correspondences pairs = ExactCorrespondences(500, motion, &rng);
  Vector6d expected;
  expected << QuaternionLog<double>(motion.rotation), motion.translation;
  for (const std::string& solver : PoseSolverNames()) {
    if (solver == "svd") continue;
    PoseSolverOptions options;
    options.name = solver;
    options.residual = ResidualTypeFromName("across_an_axis");
    const StepResult step = MakePoseSolver(options)->Step(pairs);
    EXPECT_EQ(step.system.row_count, 1000);
    EXPECT_THAT(step.increment.head<5>(), VectorNear(expected.head<5>(), 1e-4)) << solver;
    EXPECT_EQ(step.observability.degenerate_count, 1)
        << "the translation along the axis is unobservable";
  }
}

TEST(OwnResidual, RejectsEmptyAndUsedNames) {
  RegisterThem();
  for (const char* const name : {"", "point_to_plane", "my_point_to_plane"}) {
    ExpectInputError([&] { RegisterResidual<PointToPlane>(name); },
                     Names("point_to_point", "point_to_plane"));
  }
  ExpectInputError([] { ResidualTypeFromName("other"); },
                   Names("plane_to_plane", "my_point_to_point", "my_point_to_plane"));
}

}  // namespace
}  // namespace surfit::testing
