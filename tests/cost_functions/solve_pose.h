#pragma once

#include <ceres/ceres.h>

#include <vector>

#include "cost_functions/angle_axis_pose.h"
#include "cost_functions/pose_manifold.h"
#include "cost_functions/reduced_batch.h"

namespace surfit::testing {

using PoseBlock = Eigen::Matrix<double, kPoseSize, 1>;

inline PoseBlock AsBlock(const Rigid3d& pose) {
  PoseBlock block;
  PoseToBlock(pose, block.data());
  return block;
}

// Solves to the limit of double precision.
inline ceres::Solver::Summary Solve(ceres::Problem* problem) {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = 100;
  options.function_tolerance = 1e-15;
  options.gradient_tolerance = 1e-15;
  options.parameter_tolerance = 1e-14;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, problem, &summary);
  return summary;
}

template <typename Functor>
ceres::CostFunction* PerPointCost(const Functor& functor) {
  return new ceres::AutoDiffCostFunction<Functor, Functor::kResidualSize, kPoseSize>(
      new Functor(functor));
}

// The pose by one residual block per point.
template <typename Functor>
Rigid3d SolvePerPoint(const std::vector<Functor>& functors, const Rigid3d& initial,
                      ceres::Manifold* manifold) {
  PoseBlock pose = AsBlock(initial);
  ceres::Problem problem;
  problem.AddParameterBlock(pose.data(), kPoseSize, manifold);
  for (const Functor& f : functors) problem.AddResidualBlock(PerPointCost(f), nullptr, pose.data());
  Solve(&problem);
  return PoseFromBlock(pose.data());
}

template <typename Functor>
Rigid3d SolveWithAngleAxis(const std::vector<Functor>& functors, const Rigid3d& initial) {
  Eigen::Matrix<double, 6, 1> pose;
  pose << QuaternionLog<double>(initial.rotation), initial.translation;
  ceres::Problem problem;
  for (const Functor& f : functors) {
    using Cost = WithAngleAxisPose<Functor>;
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<Cost, Functor::kResidualSize, 6>(new Cost(f)), nullptr,
        pose.data());
  }
  Solve(&problem);
  return {QuaternionExp<double>(pose.head<3>()), pose.tail<3>()};
}

}  // namespace surfit::testing
