#include "refinement/joint_solver.h"

#include <ceres/problem.h>
#include <ceres/solver.h>

#include <algorithm>
#include <array>

#include "cost_functions/plane_inverse_depth.h"
#include "cost_functions/pose_manifold.h"
#include "refinement/joint_cost.h"

namespace surfit {
namespace {

ceres::Solver::Options SolverOptions(const RefinementOptions& options) {
  ceres::Solver::Options o;
  o.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  o.max_num_iterations = options.max_iterations;
  o.function_tolerance = 1e-6;  // far below the rounds': some directions hardly matter to the cost
  o.num_threads = 1;            // the cost has its own
  o.logging_type = ceres::SILENT;
  return o;
}

ceres::Problem::Options OwnedByUs() {
  ceres::Problem::Options options;
  options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  return options;
}

std::vector<int> IndicesOf(const std::vector<bool>& held) {
  std::vector<int> indices;
  for (std::size_t i = 0; i < held.size(); ++i) {
    if (held[i]) indices.push_back(static_cast<int>(i));
  }
  return indices;
}

}  // namespace

std::vector<bool> HeldCalibration(const RefinementOptions& options) {
  std::vector<bool> held(kCalibrationSize, !options.free_depth_field);
  std::fill_n(held.begin(), kFieldBegin, !options.free_intrinsics);
  held[kFieldBegin] = !options.free_depth_offset;
  return held;
}

int MinimizeJointly(const SharedSurfels& shared, const MotionPrior& prior,
                    const RobustKernel& kernel, const RefinementOptions& options,
                    JointState* state) {
  const JointState initial = *state;
  JointCost cost(shared, prior, initial, kernel);
  ProductPoseManifold pose_manifold;
  ceres::SubsetManifold free_calibration(kCalibrationSize, IndicesOf(HeldCalibration(options)));
  std::vector<std::array<double, kPoseSize>> poses(initial.world_from_camera.size());
  std::array<double, kCalibrationSize> calibration;
  CalibrationToBlock(initial.calibration, calibration.data());

  ceres::Problem problem(OwnedByUs());
  std::vector<double*> blocks;
  for (std::size_t k = 0; k < poses.size(); ++k) {
    PoseToBlock(initial.world_from_camera[k], poses[k].data());
    problem.AddParameterBlock(poses[k].data(), kPoseSize, &pose_manifold);
    blocks.push_back(poses[k].data());
  }
  problem.SetParameterBlockConstant(blocks.front());
  problem.AddParameterBlock(calibration.data(), kCalibrationSize, &free_calibration);
  blocks.push_back(calibration.data());
  problem.AddResidualBlock(&cost, nullptr, blocks);

  ceres::Solver::Summary summary;
  ceres::Solve(SolverOptions(options), &problem, &summary);
  if (!summary.IsSolutionUsable()) return kNoSolution;
  for (std::size_t k = 1; k < poses.size(); ++k) {
    state->world_from_camera[k] = PoseFromBlock(poses[k].data());
  }
  CalibrationFromBlock(calibration.data(), &state->calibration);
  return static_cast<int>(summary.iterations.size()) - 1;
}

}  // namespace surfit
