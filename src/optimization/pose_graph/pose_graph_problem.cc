#include <ceres/autodiff_cost_function.h>
#include <ceres/crs_matrix.h>
#include <ceres/solver.h>

#include "core/named_values.h"
#include "cost_functions/analytic_relative_pose.h"
#include "cost_functions/chordal_relative_pose.h"
#include "cost_functions/planar_relative_pose.h"
#include "cost_functions/sensor_position.h"
#include "cost_functions/sensor_prior.h"
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
  iteration.gradient_norm = s.gradient_norm;
  iteration.trust_region_radius = s.trust_region_radius;
  iteration.accepted = s.iteration == 0 || s.step_is_successful;
  iteration.time_ms = 1000 * s.iteration_time_in_seconds;
  return iteration;
}

ceres::CostFunction* EdgeCost(const PoseGraphEdge& edge, bool planar, RotationError error) {
  if (planar) {
    return new ceres::AutoDiffCostFunction<PlanarRelativePose, 3, kPlanarSize, kPlanarSize>(
        new PlanarRelativePose(edge.a_from_b, edge.information));
  }
  if (error == RotationError::kQuaternion) {
    return new ceres::AutoDiffCostFunction<ChordalRelativePose, 6, kPoseSize, kPoseSize>(
        new ChordalRelativePose(edge.a_from_b, edge.information));
  }
  return new AnalyticRelativePose(edge.a_from_b, edge.information);
}

template <int kResiduals, typename Functor>
ceres::CostFunction* PriorCost(const Functor& functor, bool planar) {
  if (planar) {
    using Planar = PlanarFunctor<Functor>;
    return new ceres::AutoDiffCostFunction<Planar, kResiduals, kPlanarSize>(new Planar(functor));
  }
  return new ceres::AutoDiffCostFunction<Functor, kResiduals, kPoseSize>(new Functor(functor));
}

}  // namespace

PoseGraphProblem::PoseGraphProblem(const PoseGraph& graph,
                                   const std::vector<Rigid3d>& world_from_pose,
                                   const std::vector<bool>& held, RotationError rotation_error)
    : blocks_(graph.poses.size()),
      losses_(graph.edges.size()),
      graph_(graph),
      held_(held),
      problem_(OwnedByUs()) {
  SetPoses(world_from_pose);
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    problem_.AddParameterBlock(blocks_[i].data(), block_size(),
                               graph.planar ? nullptr : &manifold_);
    if (held[i]) problem_.SetParameterBlockConstant(blocks_[i].data());
  }
  AddEdges(rotation_error);
  AddPriors();
}

int PoseGraphProblem::block_size() const { return graph_.planar ? kPlanarSize : kPoseSize; }

void PoseGraphProblem::AddEdges(RotationError rotation_error) {
  for (std::size_t i = 0; i < graph_.edges.size(); ++i) {
    const PoseGraphEdge& edge = graph_.edges[i];
    costs_.push_back(EdgeCost(edge, graph_.planar, rotation_error));
    edge_blocks_.push_back(
        problem_.AddResidualBlock(costs_.back(), edge.loop ? &losses_[i] : nullptr,
                                  blocks_[edge.a].data(), blocks_[edge.b].data()));
  }
}

void PoseGraphProblem::AddPriors() {
  for (const PoseGraphPrior& p : graph_.priors) {
    const SensorPrior functor(p.pose_from_sensor, p.world_from_sensor, p.information);
    prior_blocks_.push_back(problem_.AddResidualBlock(PriorCost<6>(functor, graph_.planar), nullptr,
                                                      blocks_[p.pose].data()));
  }
  for (const PoseGraphPosition& p : graph_.positions) {
    const SensorPosition functor(p.sensor_in_pose, p.sensor_in_world, p.information);
    prior_blocks_.push_back(problem_.AddResidualBlock(PriorCost<3>(functor, graph_.planar), nullptr,
                                                      blocks_[p.pose].data()));
  }
}

PoseGraphTermination PoseGraphProblem::Minimize(const PoseGraphOptions& options,
                                                double initial_radius, PoseGraphSummary* summary) {
  const SingleThreadedLibraries single_threaded;
  ceres::Solver::Summary solved;
  const auto before = blocks_;
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
  blocks_ = before;
  return PoseGraphTermination::kFailed;
}

void PoseGraphProblem::SetWeights(const std::vector<double>& weights) {
  for (std::size_t i = 0; i < weights.size(); ++i) losses_[i].weight = weights[i];
}

void PoseGraphProblem::SetKernel(LoopRobustness kernel, double max_squared_error) {
  for (LoopLoss& loss : losses_) {
    loss.weight = 1;
    loss.kernel = kernel;
    loss.max_squared_error = max_squared_error;
  }
}

std::vector<double> PoseGraphProblem::SquaredErrors() const {
  std::vector<double> errors;
  for (std::size_t i = 0; i < costs_.size(); ++i) {
    const PoseGraphEdge& edge = graph_.edges[i];
    const double* blocks[] = {blocks_[edge.a].data(), blocks_[edge.b].data()};
    Eigen::Matrix<double, 6, 1> residuals = Eigen::Matrix<double, 6, 1>::Zero();
    costs_[i]->Evaluate(blocks, residuals.data(), nullptr);
    errors.push_back(residuals.squaredNorm());
  }
  return errors;
}

double PoseGraphProblem::PriorError() const {
  if (prior_blocks_.empty()) return 0;
  double cost = 0;
  for (const ceres::ResidualBlockId block : prior_blocks_) {
    double half = 0;
    problem_.EvaluateResidualBlock(block, false, &half, nullptr, nullptr);
    cost += 2 * half;
  }
  return cost;
}

std::vector<Rigid3d> PoseGraphProblem::Poses() const {
  std::vector<Rigid3d> poses;
  for (const Block& block : blocks_) {
    if (graph_.planar) {
      Block lifted;
      LiftPlanarPose(block.data(), lifted.data());
      poses.push_back(PoseFromBlock(lifted.data()));
    } else {
      poses.push_back(PoseFromBlock(block.data()));
    }
  }
  return poses;
}

void PoseGraphProblem::SetPoses(const std::vector<Rigid3d>& world_from_pose) {
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    if (graph_.planar) {
      PlanarFromPose(world_from_pose[i], blocks_[i].data());
    } else {
      PoseToBlock(world_from_pose[i], blocks_[i].data());
    }
  }
}

PoseGraphProblem::Linearization PoseGraphProblem::Linearize(const std::vector<bool>& used_edges) {
  Linearization result;
  result.first_column.assign(blocks_.size(), -1);
  result.first_row.assign(edge_blocks_.size(), -1);
  result.edge_rows = graph_.planar ? 3 : 6;
  ceres::Problem::EvaluateOptions options;
  options.apply_loss_function = false;
  std::vector<bool> is_measured(blocks_.size(), false);
  int row = 0;
  for (std::size_t i = 0; i < edge_blocks_.size(); ++i) {
    if (!used_edges[i]) continue;
    options.residual_blocks.push_back(edge_blocks_[i]);
    is_measured[graph_.edges[i].a] = is_measured[graph_.edges[i].b] = true;
    result.first_row[i] = row;
    row += result.edge_rows;
  }
  options.residual_blocks.insert(options.residual_blocks.end(), prior_blocks_.begin(),
                                 prior_blocks_.end());
  for (const PoseGraphPrior& prior : graph_.priors) is_measured[prior.pose] = true;
  for (const PoseGraphPosition& position : graph_.positions) is_measured[position.pose] = true;
  int column = 0;
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    if (held_[i] || !is_measured[i]) continue;
    options.parameter_blocks.push_back(blocks_[i].data());
    result.first_column[i] = column;
    column += graph_.planar ? 3 : 6;
  }
  if (column == 0 || options.residual_blocks.empty()) {
    result.jacobian.resize(0, column);
    return result;
  }
  ceres::CRSMatrix rows;
  problem_.Evaluate(options, nullptr, nullptr, nullptr, &rows);
  result.jacobian.resize(rows.num_rows, column);
  std::vector<Eigen::Triplet<double>> entries;
  for (int r = 0; r < rows.num_rows; ++r) {
    for (int k = rows.rows[r]; k < rows.rows[r + 1]; ++k) {
      entries.emplace_back(r, rows.cols[k], rows.values[k]);
    }
  }
  result.jacobian.setFromTriplets(entries.begin(), entries.end());
  return result;
}

}  // namespace surfit
