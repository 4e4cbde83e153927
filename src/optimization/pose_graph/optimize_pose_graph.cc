#include "optimization/pose_graph/optimize_pose_graph.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "core/trace.h"
#include "optimization/pose_graph/pose_graph_names.h"
#include "surfit/core/options.h"
#include "surfit/optimization/pose_graph.h"

namespace surfit {
namespace {

// Limits of the GNC rounds before the final round.
constexpr int kRoundIterations = 10;
constexpr double kRoundCostChange = 1e-3;
// Enough rounds for an initial mu of 1e-30.
constexpr int kMaxRounds = 300;

std::vector<Rigid3d> PosesOf(const PoseGraph& graph) {
  std::vector<Rigid3d> poses;
  for (const PoseGraphPose& pose : graph.poses) poses.push_back(pose.world_from_pose);
  return poses;
}

bool UsesGnc(const PoseGraphOptions& options) {
  return ValueOf("loop_robustness", options.loop_robustness, kLoopRobustness) ==
         LoopRobustness::kGnc;
}

PoseGraphInitialization InitializationOf(const PoseGraphOptions& options) {
  const auto way = ValueOf("initialization", options.initialization, kInitializations);
  const bool misled = UsesGnc(options) && way == PoseGraphInitialization::kChordal;
  return misled ? PoseGraphInitialization::kOdometry : way;
}

std::optional<std::vector<Rigid3d>> Initialize(PoseGraphInitialization way, const PoseGraph& graph,
                                               const ChainedPoses& chained) {
  switch (way) {
    case PoseGraphInitialization::kGiven:
      return PosesOf(graph);
    case PoseGraphInitialization::kOdometry:
      return chained.world_from_pose;
    case PoseGraphInitialization::kChordal:
      return ChordalPoses(graph, chained.held);
  }
  return std::nullopt;
}

std::vector<std::size_t> LoopsOf(const PoseGraph& graph) {
  std::vector<std::size_t> loops;
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    if (graph.edges[i].loop) loops.push_back(i);
  }
  return loops;
}

std::vector<double> Select(const std::vector<double>& all,
                           const std::vector<std::size_t>& indices) {
  std::vector<double> selected;
  for (const std::size_t i : indices) selected.push_back(all[i]);
  return selected;
}

std::vector<double> EdgeWeights(const std::vector<double>& loop_weights,
                                const std::vector<std::size_t>& loops, std::size_t edge_count) {
  std::vector<double> weights(edge_count, 1);
  for (std::size_t i = 0; i < loops.size(); ++i) weights[loops[i]] = loop_weights[i];
  return weights;
}

// Runs GNC, sets the weights of outlier loop closures to 0, and lists the outliers. Returns
// false if a solver run failed.
bool FindWrongLoops(const PoseGraph& graph, const PoseGraphOptions& options,
                    PoseGraphProblem* problem, PoseGraphSummary* summary) {
  PoseGraphOptions round = options;
  round.max_iterations = std::min(options.max_iterations, kRoundIterations);
  round.min_relative_cost_change = std::max(options.min_relative_cost_change, kRoundCostChange);
  const std::vector<std::size_t> loops = LoopsOf(graph);
  const auto solve = [&] {
    return problem->Minimize(round, kFarFromMinimum, summary) != PoseGraphTermination::kFailed;
  };
  LoopWeights gnc(options.max_loop_squared_error, Select(problem->SquaredErrors(), loops));
  std::vector<double> weights;
  for (int i = 0; i < kMaxRounds; ++i) {
    weights = gnc.Update(Select(problem->SquaredErrors(), loops));
    problem->SetWeights(EdgeWeights(weights, loops, graph.edges.size()));
    if (AreBinary(weights)) break;
    if (!solve()) return false;
  }
  for (double& weight : weights) weight = weight < 0.5 ? 0 : 1;
  problem->SetWeights(EdgeWeights(weights, loops, graph.edges.size()));
  for (std::size_t i = 0; i < loops.size(); ++i) {
    if (weights[i] == 0) summary->outlier_edges.push_back(loops[i]);
  }
  return true;
}

double CountedCost(const std::vector<double>& squared_errors,
                   const std::vector<std::size_t>& left_out) {
  std::vector<double> counted = squared_errors;
  for (const std::size_t i : left_out) counted[i] = 0;
  return std::accumulate(counted.begin(), counted.end(), 0.) / 2;
}

PoseGraphTermination Solve(const PoseGraph& graph, const PoseGraphOptions& options,
                           PoseGraphProblem* problem, PoseGraphSummary* summary) {
  const StageTimer timer("solve", TraceSlice::kNoFrame, &summary->solve_ms);
  if (UsesGnc(options) && !FindWrongLoops(graph, options, problem, summary)) {
    return PoseGraphTermination::kFailed;
  }
  const bool is_near = InitializationOf(options) == PoseGraphInitialization::kChordal;
  return problem->Minimize(options, is_near ? kNearMinimum : kFarFromMinimum, summary);
}

void TakePoses(const PoseGraphProblem& problem, const std::vector<bool>& held, PoseGraph* graph) {
  const std::vector<Rigid3d> poses = problem.Poses();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!held[i]) graph->poses[i].world_from_pose = poses[i];
  }
}

}  // namespace

PoseGraphSummary OptimizePoseGraph(const PoseGraphOptions& options, PoseGraph* graph) {
  Validate(options);
  graph->Validate();
  PoseGraphSummary summary;
  summary.sparse_backend = options.sparse_backend;
  summary.given_cost = Cost(*graph);
  summary.loop_count = LoopsOf(*graph).size();

  std::optional<StageTimer> timer(std::in_place, "initialize", TraceSlice::kNoFrame,
                                  &summary.initialize_ms);
  const ChainedPoses chained = ChainPoses(*graph);
  summary.held_count = std::count(chained.held.begin(), chained.held.end(), true);
  const auto initial = Initialize(InitializationOf(options), *graph, chained);
  if (!initial) return summary;
  PoseGraphProblem problem(*graph, *initial, chained.held);
  timer.reset();

  summary.initial_cost = CountedCost(problem.SquaredErrors(), {});
  summary.termination = Solve(*graph, options, &problem, &summary);
  summary.final_cost = CountedCost(problem.SquaredErrors(), summary.outlier_edges);
  if (!std::isfinite(summary.final_cost)) summary.termination = PoseGraphTermination::kFailed;
  if (summary.Succeeded()) TakePoses(problem, chained.held, graph);
  return summary;
}

}  // namespace surfit
