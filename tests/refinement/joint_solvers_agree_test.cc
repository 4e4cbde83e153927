// Compares the solvers of a refinement round at convergence.
#include <gtest/gtest.h>

#include <string>
#include <tuple>

#include "optimization/refinement/joint_solver.h"
#include "refinement/random_surfels.h"
#include "surfit/core/parallel.h"
#include "testing/random_pose.h"

namespace surfit::testing {
namespace {

constexpr int kCameras = 12, kSurfelCount = 600;

// Noise of one sigma. One surfel in twenty has an outlier of 30 sigmas.
RandomProblem WrongStart(bool textured) {
  RandomProblem problem = MakeRandomProblem(kCameras, kSurfelCount, 1);
  std::mt19937_64 random(3);
  for (int k = 1; k < kCameras; ++k) {
    Rigid3d& pose = problem.state.world_from_camera[k];
    pose = pose * RandomPose(0.002, 0.004, &random);
  }
  for (std::size_t s = 0; s < kSurfelCount; s += 20) {
    PlaneObservation& o = problem.shared.observations[problem.shared.surfels[s].begin];
    o.inverse_depth += 30 / o.inverse_sigma;
  }
  if (!textured) {
    problem.shared.textures.clear();
    for (SharedSurfel& surfel : problem.shared.surfels)
      surfel.textures_begin = surfel.textures_end = 0;
  }
  return problem;
}

RefinementOptions ToConvergence(bool free_calibration) {
  RefinementOptions options;
  options.estimate_intrinsics = options.estimate_depth_offset = options.estimate_depth_field =
      free_calibration;
  options.estimate_readout = free_calibration;
  options.max_iterations = 200;
  options.min_relative_step_change = 1e-12;
  return options;
}

JointPrior GivenPrior(const RandomProblem& problem, const RefinementOptions& options) {
  JointPrior prior = options.estimate_intrinsics
                         ? JointPrior(problem.state.calibration, CalibrationPrior())
                         : JointPrior(problem.state.world_from_camera, options.motion_sigma_m,
                                      options.motion_sigma_rad);
  prior.SetWeight(2);
  return prior;
}

constexpr JointKernels kFixedKernels = {{RobustKernelType::kGemanMcClure, 6},
                                        {RobustKernelType::kHuber, 3}};

double CostOf(const RandomProblem& problem, const JointPrior& prior) {
  return (FitOf(problem.shared, problem.state, kFixedKernels).rho + prior.Rho(problem.state)) / 2;
}

using Case = std::tuple<bool, bool, std::string>;  // textured, free calibration, linear solver

class JointSolvers : public ::testing::TestWithParam<Case> {};

TEST_P(JointSolvers, ReachSameCost) {
  const auto [textured, free_calibration, linear_solver] = GetParam();
  RandomProblem by_hand = WrongStart(textured);
  RefinementOptions options = ToConvergence(free_calibration);
  const JointPrior prior = GivenPrior(by_hand, options);
  RandomProblem by_ceres = by_hand;
  const double before = CostOf(by_hand, prior);

  const JointReport hand =
      MinimizeJointly({by_hand.shared, prior, kFixedKernels}, options, &by_hand.state);
  options.solver = "ceres";
  options.linear_solver = linear_solver;
  const JointReport ceres =
      MinimizeJointly({by_ceres.shared, prior, kFixedKernels}, options, &by_ceres.state);

  ASSERT_GT(hand.iterations, 1);
  ASSERT_GT(ceres.iterations, 1);
  EXPECT_LT(ceres.iterations, options.max_iterations);
  const double expected = CostOf(by_hand, prior), cost = CostOf(by_ceres, prior);
  EXPECT_LT(expected, 0.99 * before);  // the initial cost is larger
  EXPECT_NEAR(cost, expected, 1e-6 * expected);
  EXPECT_NEAR(hand.costs.back(), expected, 1e-6 * expected);
  // The cost of Ceres refers to converged surfels. The reduced solver updates surfels in four
  // steps, which leaves a small difference.
  EXPECT_NEAR(ceres.costs.front(), before, 1e-5 * before);
  EXPECT_NEAR(ceres.costs.back(), cost, 1e-5 * cost);
  EXPECT_LE(ceres.costs.back(), cost);
  if (!free_calibration) {
    EXPECT_EQ(by_ceres.state.calibration.camera.fx, by_hand.state.calibration.camera.fx);
  }
}

std::string NameOfCase(const ::testing::TestParamInfo<Case>& info) {
  return std::string(std::get<0>(info.param) ? "Textures" : "Planes") +
         (std::get<1>(info.param) ? "Free" : "Held") +
         (std::get<2>(info.param) == "sparse_schur" ? "Sparse" : "Iterative");
}

INSTANTIATE_TEST_SUITE_P(All, JointSolvers,
                         ::testing::Combine(::testing::Bool(), ::testing::Bool(),
                                            ::testing::Values("sparse_schur", "iterative_schur")),
                         NameOfCase);

TEST(JointSolversThreads, AreBitwiseIdentical) {
  for (const char* solver : {"reduced", "ceres"}) {
    SCOPED_TRACE(solver);
    RefinementOptions options = ToConvergence(true);
    options.solver = solver;
    options.max_iterations = 3;
    RandomProblem problems[2] = {WrongStart(true), WrongStart(true)};
    for (int i = 0; i < 2; ++i) {
      const ThreadLimit threads(i + 1);
      const JointPrior prior = GivenPrior(problems[i], options);
      MinimizeJointly({problems[i].shared, prior, kFixedKernels}, options, &problems[i].state);
    }
    for (int k = 0; k < kCameras; ++k) {
      EXPECT_EQ(problems[0].state.world_from_camera[k].Matrix(),
                problems[1].state.world_from_camera[k].Matrix());
    }
    EXPECT_EQ(problems[0].state.calibration.camera.fx, problems[1].state.calibration.camera.fx);
  }
}

}  // namespace
}  // namespace surfit::testing
