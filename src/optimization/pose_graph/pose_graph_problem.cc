#include <ceres/solver.h>

#include "core/named_values.h"
#include "cost_functions/analytic_relative_pose.h"
#include "optimization/pose_graph/optimize_pose_graph.h"
#include "optimization/pose_graph/pose_graph_names.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

ceres::Problem::Options OwnedByUs() {
  ceres::Problem::Options options;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  return options;
}

ceres::Solver::Options SolverOptions(const PoseGraphOptions& options) {
  ceres::Solver::Options o;
  o.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  o.sparse_linear_algebra_library_type =
      ValueOf("sparse_backend", options.sparse_backend, kSparseBackends);
  o.max_num_iterations = options.max_iterations;
  o.function_tolerance = options.min_relative_cost_change;
  o.gradient_tolerance = 0;  // depends on the unit of the information: only the cost is tested
  o.parameter_tolerance = 0;
  o.num_threads = 1;  // with more threads, Ceres sums costs and gradients in a varying order
  o.logging_type = ceres::SILENT;
  return o;
}

PoseGraphIteration AsIteration(const ceres::IterationSummary& s, int round) {
  PoseGraphIteration iteration;
  iteration.round = round;
  iteration.cost = s.cost;
  iteration.step_norm = s.step_norm;
  iteration.accepted = s.iteration == 0 || s.step_is_successful;
  iteration.time_ms = 1000 * s.iteration_time_in_seconds;
  return iteration;
}

}  // namespace

PoseGraphProblem::PoseGraphProblem(const PoseGraph& graph,
                                   const std::vector<Rigid3d>& world_from_pose,
                                   const std::vector<bool>& held)
    : poses_(graph.poses.size()),
      losses_(graph.edges.size()),
      graph_(graph),
      problem_(OwnedByUs()) {
  for (std::size_t i = 0; i < poses_.size(); ++i) {
    PoseToBlock(world_from_pose[i], poses_[i].data());
    problem_.AddParameterBlock(poses_[i].data(), kPoseSize, &manifold_);
    if (held[i]) problem_.SetParameterBlockConstant(poses_[i].data());
  }
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    const PoseGraphEdge& edge = graph.edges[i];
    auto* cost = new AnalyticRelativePose(edge.a_from_b, edge.information);
    costs_.push_back(cost);
    problem_.AddResidualBlock(cost, edge.loop ? &losses_[i] : nullptr, poses_[edge.a].data(),
                              poses_[edge.b].data());
  }
}

PoseGraphTermination PoseGraphProblem::Minimize(const PoseGraphOptions& options,
                                                double initial_radius, PoseGraphSummary* summary) {
  const SingleThreadedLibraries single_threaded;
  ceres::Solver::Summary solved;
  const auto before = poses_;
  ceres::Solver::Options solver_options = SolverOptions(options);
  solver_options.initial_trust_region_radius = initial_radius;
  ceres::Solve(solver_options, &problem_, &solved);
  for (const ceres::IterationSummary& iteration : solved.iterations) {
    summary->iterations.push_back(AsIteration(iteration, summary->round_count));
  }
  ++summary->round_count;
  if (solved.IsSolutionUsable()) {
    return solved.termination_type == ceres::CONVERGENCE ? PoseGraphTermination::kConverged
                                                         : PoseGraphTermination::kMaxIterations;
  }
  poses_ = before;
  return PoseGraphTermination::kFailed;
}

void PoseGraphProblem::SetWeights(const std::vector<double>& weights) {
  for (std::size_t i = 0; i < weights.size(); ++i) losses_[i].weight = weights[i];
}

std::vector<double> PoseGraphProblem::SquaredErrors() const {
  std::vector<double> errors;
  for (std::size_t i = 0; i < costs_.size(); ++i) {
    const PoseGraphEdge& edge = graph_.edges[i];
    const double* blocks[] = {poses_[edge.a].data(), poses_[edge.b].data()};
    Eigen::Matrix<double, 6, 1> residuals;
    costs_[i]->Evaluate(blocks, residuals.data(), nullptr);
    errors.push_back(residuals.squaredNorm());
  }
  return errors;
}

std::vector<Rigid3d> PoseGraphProblem::Poses() const {
  std::vector<Rigid3d> poses;
  for (const auto& block : poses_) poses.push_back(PoseFromBlock(block.data()));
  return poses;
}

}  // namespace surfit
