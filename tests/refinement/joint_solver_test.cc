// Our descent against Ceres' over all rows, by autodiff, displacements included.
#include "refinement/joint_solver.h"

#include <ceres/autodiff_cost_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>
#include <gtest/gtest.h>

#include <array>

#include "cost_functions/pose_manifold.h"
#include "refinement/calibration_block.h"
#include "refinement/random_surfels.h"
#include "testing/random_pose.h"

namespace surfit {
namespace {

using testing::MakeRandomProblem;
using testing::RandomPose;
using testing::RandomProblem;

constexpr int kPoses = 12, kSurfels = 600;

// The least cost, by Ceres.
double CeresCost(const RandomProblem& problem) {
  using Plane = ceres::AutoDiffCostFunction<PlaneInverseDepth, 1, kPoseSize, kCalibrationSize, 1>;
  using Texture = ceres::AutoDiffCostFunction<SurfelTexture, 2, kPoseSize, kCalibrationSize, 1, 2>;
  std::vector<std::array<double, kPoseSize>> poses(kPoses);
  std::array<double, kCalibrationSize> calibration;
  std::vector<double> displacements(problem.shared.surfels.size(), 0.);
  std::vector<std::array<double, 2>> textures(displacements.size(), {0, 0});
  CalibrationToBlock(problem.state.calibration, calibration.data());
  ceres::Problem ceres_problem;
  for (int k = 0; k < kPoses; ++k) {
    PoseToBlock(problem.state.world_from_camera[k], poses[k].data());
    ceres_problem.AddParameterBlock(poses[k].data(), kPoseSize, new ProductPoseManifold);
  }
  ceres_problem.SetParameterBlockConstant(poses[0].data());
  for (std::size_t s = 0; s < displacements.size(); ++s) {
    const SharedSurfel& surfel = problem.shared.surfels[s];
    for (std::size_t i = surfel.begin; i < surfel.end; ++i) {
      const PlaneObservation& o = problem.shared.observations[i];
      ceres_problem.AddResidualBlock(
          new Plane(new PlaneInverseDepth(o.u, o.v, o.inverse_depth, 1. / o.inverse_sigma,
                                          surfel.point_in_world, surfel.normal_in_world)),
          nullptr, poses[o.keyframe].data(), calibration.data(), &displacements[s]);
    }
    for (std::size_t i = surfel.textures_begin; i < surfel.textures_end; ++i) {
      const TextureObservation& o = problem.shared.textures[i];
      ceres_problem.AddResidualBlock(
          new Texture(new SurfelTexture(o.taps, 1. / o.inverse_sigma, TexturePoints(surfel),
                                        surfel.normal_in_world)),
          nullptr, poses[o.keyframe].data(), calibration.data(), &displacements[s],
          textures[s].data());
    }
  }
  // Only the offset of inverse depth is free: the other nine are held.
  std::vector<int> held(kCalibrationSize);
  for (int i = 0; i < kCalibrationSize; ++i) held[i] = i;
  held.erase(held.begin() + kFieldBegin);
  ceres_problem.SetManifold(calibration.data(), new ceres::SubsetManifold(kCalibrationSize, held));
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.max_num_iterations = 100;
  options.function_tolerance = 1e-12;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &ceres_problem, &summary);
  return summary.final_cost;
}

TEST(MinimizeJointly, ReachesTheCostOfCeresOverAllRows) {
  for (const int reach : {1, kPoses}) {
    RandomProblem problem = MakeRandomProblem(kPoses, kSurfels, 1, reach);
    std::mt19937_64 random(3);
    for (int k = 1; k < kPoses; ++k) {
      Rigid3d& pose = problem.state.world_from_camera[k];
      pose = pose * RandomPose(0.01, 0.02, &random);
    }
    problem.state.calibration.field.coefficients[0] += 0.005;
    const JointKernels none = {{RobustKernelType::kNone, 1}, {RobustKernelType::kNone, 1}};
    RefinementOptions options;
    options.free_intrinsics = false;
    options.max_iterations = 100;
    const Rigid3d first = problem.state.world_from_camera[0];
    const double before = FitOf(problem.shared, problem.state, none).rho / 2;
    const double expected = CeresCost(problem);
    ASSERT_GT(MinimizeJointly(problem.shared, {}, none, options, &problem.state), 0);
    const double cost = FitOf(problem.shared, problem.state, none).rho / 2;
    EXPECT_LT(expected, before / 2);  // there was something to do
    // Both are at the least cost but for the change, a millionth, that ends ours.
    EXPECT_NEAR(cost, expected, 1e-6 * expected);
    EXPECT_EQ(problem.state.world_from_camera[0].Matrix(), first.Matrix());
  }
}

TEST(MinimizeJointly, LeavesAStateWithoutFiniteCostAsItWas) {
  RandomProblem problem = MakeRandomProblem(kPoses, kSurfels, 1);
  problem.shared.observations[0].inverse_depth = std::nanf("");
  const Rigid3d last = problem.state.world_from_camera.back();
  EXPECT_EQ(MinimizeJointly(problem.shared, {}, {}, {}, &problem.state), kNoSolution);
  EXPECT_EQ(problem.state.world_from_camera.back().Matrix(), last.Matrix());
}

}  // namespace
}  // namespace surfit
