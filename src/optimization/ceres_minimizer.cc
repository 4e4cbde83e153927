#include "optimization/ceres_minimizer.h"

#include <ceres/solver.h>

#include "optimization/single_threaded_blas.h"

namespace surfit {
namespace {

ceres::Problem::Options OwnedByUs() {
  ceres::Problem::Options options;
  options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  return options;
}

ceres::Solver::Options SolverOptions(const MinimizerOptions& options) {
  ceres::Solver::Options o;
  o.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  o.initial_trust_region_radius = options.initial_radius;
  o.max_num_iterations = options.max_iterations;
  o.function_tolerance = options.min_relative_cost_change;
  o.gradient_tolerance = 0;  // has units of the information: the cost alone decides
  o.parameter_tolerance = 0;
  o.num_threads = 1;  // with more, Ceres sums costs and gradients in no fixed order
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

CeresMinimizer::CeresMinimizer(ceres::SparseLinearAlgebraLibraryType backend,
                               PoseGraphProblem* problem)
    : backend_(backend),
      problem_(problem),
      blocks_(problem->world_from_pose.size()),
      losses_(problem->costs.size()),
      ceres_problem_(OwnedByUs()) {
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    ceres_problem_.AddParameterBlock(blocks_[i].data(), kPoseSize, &manifold_);
    if (problem->held[i]) ceres_problem_.SetParameterBlockConstant(blocks_[i].data());
  }
  for (std::size_t i = 0; i < losses_.size(); ++i) {
    const PoseGraphEdge& edge = problem->graph.edges[i];
    losses_[i].problem = problem;
    losses_[i].edge = i;
    // Ceres does not change cost functions.
    ceres_problem_.AddResidualBlock(const_cast<AnalyticRelativePose*>(problem->costs[i].get()),
                                    edge.loop ? &losses_[i] : nullptr, blocks_[edge.a].data(),
                                    blocks_[edge.b].data());
  }
}

PoseGraphTermination CeresMinimizer::Minimize(const MinimizerOptions& options,
                                              PoseGraphSummary* summary) {
  const SingleThreadedBlas single_threaded;
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    PoseToBlock(problem_->world_from_pose[i], blocks_[i].data());
  }
  ceres::Solver::Options solver_options = SolverOptions(options);
  solver_options.sparse_linear_algebra_library_type = backend_;
  ceres::Solver::Summary solved;
  ceres::Solve(solver_options, &ceres_problem_, &solved);
  for (const ceres::IterationSummary& iteration : solved.iterations) {
    summary->iterations.push_back(AsIteration(iteration, summary->round_count));
  }
  if (!solved.IsSolutionUsable()) return PoseGraphTermination::kFailed;
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    problem_->world_from_pose[i] = PoseFromBlock(blocks_[i].data());
  }
  return solved.termination_type == ceres::CONVERGENCE ? PoseGraphTermination::kConverged
                                                       : PoseGraphTermination::kMaxIterations;
}

}  // namespace surfit
