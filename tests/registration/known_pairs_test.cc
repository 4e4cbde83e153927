// Tests of pose solvers with exact, known correspondences.
#include <gtest/gtest.h>

#include "registration/random_correspondences.h"
#include "surfit/registration/pose_solver.h"
#include "testing/matchers.h"
#include "testing/random_pose.h"

namespace surfit::testing {
namespace {

struct Combination {
  std::string solver;
  ResidualType residual;
};

std::vector<Combination> AllCombinations() {
  std::vector<Combination> all;
  for (const std::string& solver : PoseSolverNames()) {
    for (const std::string& residual : ResidualTypeNames()) {
      if (solver == "svd" && residual != "point_to_point") continue;
      all.push_back({solver, ResidualTypeFromName(residual)});
    }
  }
  return all;
}

std::string NameOf(const ::testing::TestParamInfo<Combination>& info) {
  return info.param.solver + "_" + ToString(info.param.residual);
}

Rigid3d SolveKnown(const Correspondences& pairs, const PoseSolverOptions& options) {
  constexpr int kMaxSteps = 30;
  const std::unique_ptr<PoseSolver> solver = MakePoseSolver(options);
  Rigid3d pose;
  for (int i = 0; i < kMaxSteps; ++i) {
    const Vector6d step = solver->Step(Moved(pairs, pose)).increment;
    pose = LeftIncrement(step, pose);
    if (step.norm() < 1e-13) break;
  }
  return pose;
}

class KnownPairs : public ::testing::TestWithParam<Combination> {
 protected:
  PoseSolverOptions Options(RobustKernelType kernel = RobustKernelType::kNone) const {
    PoseSolverOptions options;
    options.name = GetParam().solver;
    options.residual = GetParam().residual;
    options.error_model.kernel = {kernel, 3};
    return options;
  }
};

// Exact data: residuals vanish to 1e-15 m, and all eigenvalues are above 1e-2.
TEST_P(KnownPairs, RecoverEachDegreeOfFreedom) {
  std::mt19937_64 rng(1);
  for (const Vector6d& motion : EachDirection(0.2, 0.3)) {
    const Rigid3d expected = LeftIncrement<double>(motion, Rigid3d());
    const Correspondences pairs = ExactCorrespondences(200, expected, &rng);
    EXPECT_THAT(SolveKnown(pairs, Options()), RigidNear(expected, 1e-9, 1e-9))
        << motion.transpose();
  }
}

TEST_P(KnownPairs, RecoverMotionWithRobustKernel) {
  std::mt19937_64 rng(7);
  for (int i = 0; i < 3; ++i) {
    const Rigid3d expected = RandomPose(0.3, 0.3, &rng);
    const Correspondences pairs = ExactCorrespondences(200, expected, &rng);
    EXPECT_THAT(SolveKnown(pairs, Options(RobustKernelType::kHuber)),
                RigidNear(expected, 1e-9, 1e-9));
  }
}

// Noise keeps the minimum above zero, so only solvers that iterate to the minimum reach it in one
// step.
TEST_P(KnownPairs, ReachMinimumInOneStepIfReachesMinimum) {
  std::mt19937_64 rng(8);
  const Correspondences start = RandomCorrespondences(500, 0.05, &rng);
  const Correspondences pairs = Moved(start, RandomPose(0.2, 0.2, &rng));
  const std::unique_ptr<PoseSolver> solver = MakePoseSolver(Options());
  const StepResult step = solver->Step(pairs);
  const Rigid3d motion = LeftIncrement<double>(step.increment, Rigid3d());
  const StepResult next = solver->Step(Moved(pairs, motion));
  // The closed-form plane_to_plane residual uses the whitening of the current rotation. The next
  // step updates it.
  if (GetParam().residual != ResidualType::kPlaneToPlane) {
    EXPECT_EQ(next.increment.norm() < 1e-6, solver->ReachesMinimum()) << next.increment.norm();
  }
  ASSERT_FALSE(step.report.costs.empty());
  EXPECT_NEAR(step.report.costs.front(), step.system.cost, 1e-9 * step.system.cost);
  EXPECT_LT(next.report.costs.front(), step.report.costs.front());
  EXPECT_EQ(step.report.costs.size() > 1, GetParam().solver == "ceres" ||
                                              GetParam().solver == "ceres_per_point" ||
                                              GetParam().solver == "tiny");
}

// Single-precision correspondences: coordinates of 4 m have rounding errors of 2.4e-7 m, which is
// smaller in the mean of 500.
TEST_P(KnownPairs, AgreeInSinglePrecision) {
  std::mt19937_64 rng(9);
  const Correspondences pairs = RandomCorrespondences(500, 0.05, &rng);
  const std::unique_ptr<PoseSolver> solver = MakePoseSolver(Options());
  const Vector6d expected = solver->Step(pairs).increment;
  const Vector6d single = solver->Step(Rounded<float>(pairs)).increment;
  EXPECT_LT((single - expected).norm(), 1e-6);
}

INSTANTIATE_TEST_SUITE_P(All, KnownPairs, ::testing::ValuesIn(AllCombinations()), NameOf);

// With noise, all solvers of a residual converge to the same minimum.
class SolversOf : public ::testing::TestWithParam<std::string> {};

TEST_P(SolversOf, ReachSameMinimum) {
  std::mt19937_64 rng(8);
  const Rigid3d motion = RandomPose(0.1, 0.1, &rng);
  const Correspondences random = ExactCorrespondences(400, motion, &rng);
  Correspondences pairs;
  for (int i = 0; i < random.size; ++i) {
    pairs.Add(random.p(i), random.q(i) + RandomVector(0.01, &rng), random.n(i), random.m(i),
              random.information[i]);
  }
  PoseSolverOptions options;
  options.residual = ResidualTypeFromName(GetParam());
  for (const RobustKernelType kernel : {RobustKernelType::kNone, RobustKernelType::kHuber}) {
    options.error_model.kernel = {kernel, 0.01};
    options.name = "closed_form_ldlt";
    const Rigid3d expected = SolveKnown(pairs, options);
    for (const std::string& solver : PoseSolverNames()) {
      if (solver == "svd" && GetParam() != "point_to_point") continue;
      options.name = solver;
      EXPECT_THAT(SolveKnown(pairs, options), RigidNear(expected, 1e-6, 1e-6))
          << solver << ", kernel " << ToString(kernel);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Residuals, SolversOf, ::testing::ValuesIn(ResidualTypeNames()),
                         [](const auto& instance) { return instance.param; });

// Points and their mirror image. Without the sign of the determinant, a reflection would be
// optimal.
TEST(SvdSolver, NeverReflects) {
  std::mt19937_64 rng(9);
  Correspondences pairs;
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector3d p = RandomVector(1, &rng);
    pairs.Add(p, {p.x(), p.y(), -p.z()}, {0, 0, 1}, {0, 0, 1}, 1);
  }
  PoseSolverOptions options;
  options.name = "svd";
  options.residual = ResidualType::kPointToPoint;
  options.error_model.kernel.type = RobustKernelType::kNone;
  const StepResult step = MakePoseSolver(options)->Step(pairs);
  const Rigid3d pose = LeftIncrement<double>(step.increment, Rigid3d());
  EXPECT_NEAR(pose.rotation.toRotationMatrix().determinant(), 1, 1e-12);
  // The pose is the optimal rotation: a closed-form step does not improve it.
  options.name = "closed_form_ldlt";
  EXPECT_LT(MakePoseSolver(options)->Step(Moved(pairs, pose)).increment.norm(), 1e-9);
}

}  // namespace
}  // namespace surfit::testing
