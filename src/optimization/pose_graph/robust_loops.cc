#include "optimization/pose_graph/robust_loops.h"

namespace surfit {
namespace {

// mu grows by a factor of 1.4 per round: from 1e-30 for an extreme error to binary weights.
constexpr int kMaxRounds = 300;
// The truncated cost decreases in each round of PolishTruncated(), so that rounds end.
constexpr int kMaxPolishRounds = 20;

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

std::vector<std::size_t> LoopsAbove(const PoseGraph& graph, const std::vector<double>& errors,
                                    double max_squared_error) {
  std::vector<std::size_t> outliers;
  for (const std::size_t i : LoopsOf(graph)) {
    if (errors[i] > max_squared_error) outliers.push_back(i);
  }
  return outliers;
}

std::vector<double> WeightsWithout(const std::vector<std::size_t>& outliers, std::size_t count) {
  std::vector<double> weights(count, 1);
  for (const std::size_t i : outliers) weights[i] = 0;
  return weights;
}

// Sets binary weights of the loop closures: see LoopWeights. Returns false if a solver run failed.
bool FindWrongLoops(const PoseGraph& graph, const PoseGraphOptions& options,
                    PoseGraphProblem* problem, PoseGraphSummary* summary) {
  PoseGraphOptions round = options;
  round.max_iterations = std::min(options.max_iterations, options.max_round_iterations);
  round.min_relative_cost_change =
      std::max(options.min_relative_cost_change, options.min_round_cost_change);
  const std::vector<std::size_t> loops = LoopsOf(graph);
  const auto solve = [&] {
    return problem->Minimize(round, kFarFromMinimum, summary) != PoseGraphTermination::kFailed;
  };
  // The paper starts from the minimum with all weights 1. With the start "odometry", the errors of
  // the odometry poses give the first weights.
  const bool from_odometry =
      ValueOf("start", options.start, kPoseGraphStarts) == PoseGraphStart::kOdometry;
  if (!from_odometry && !solve()) return false;
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

}  // namespace

void LoopLoss::Evaluate(double squared_error, double rho[3]) const {
  const double s = squared_error, c2 = max_squared_error;
  rho[0] = weight * s;
  rho[1] = weight;
  rho[2] = 0;
  switch (kernel) {
    case LoopRobustness::kNone:
    case LoopRobustness::kGnc:
    case LoopRobustness::kAuto:
      return;
    case LoopRobustness::kDcs:
      if (s <= c2) return;
      rho[0] = weight * (3 * c2 - 4 * c2 * c2 / (c2 + s));
      rho[1] = weight * std::pow(2 * c2 / (c2 + s), 2);
      rho[2] = -2 * rho[1] / (c2 + s);
      return;
    case LoopRobustness::kHuber:
      if (s <= c2) return;
      rho[0] = weight * (2 * std::sqrt(c2 * s) - c2);
      rho[1] = weight * std::sqrt(c2 / s);
      rho[2] = -rho[1] / (2 * s);
      return;
    case LoopRobustness::kCauchy:
      rho[0] = weight * c2 * std::log1p(s / c2);
      rho[1] = weight * c2 / (c2 + s);
      rho[2] = -rho[1] / (c2 + s);
      return;
    case LoopRobustness::kGemanMcClure:
      rho[0] = weight * c2 * s / (c2 + s);
      rho[1] = weight * std::pow(c2 / (c2 + s), 2);
      rho[2] = -2 * rho[1] / (c2 + s);
      return;
  }
}

PoseGraphTermination SolveRobustly(const PoseGraph& graph, const PoseGraphOptions& options,
                                   double initial_radius, PoseGraphProblem* problem,
                                   PoseGraphSummary* summary) {
  const auto kernel = ValueOf("loop_robustness", options.loop_robustness, kLoopRobustness);
  if (kernel == LoopRobustness::kNone) return problem->Minimize(options, initial_radius, summary);
  if (kernel == LoopRobustness::kGnc) {
    if (!FindWrongLoops(graph, options, problem, summary)) return PoseGraphTermination::kFailed;
    return problem->Minimize(options, kFarFromMinimum, summary);
  }
  problem->SetKernel(kernel, options.max_loop_squared_error);
  const PoseGraphTermination termination = problem->Minimize(options, kFarFromMinimum, summary);
  summary->outlier_edges =
      LoopsAbove(graph, problem->SquaredErrors(), options.max_loop_squared_error);
  return termination;
}

PoseGraphTermination PolishTruncated(const PoseGraph& graph, const PoseGraphOptions& options,
                                     PoseGraphProblem* problem, PoseGraphSummary* summary) {
  problem->SetKernel(LoopRobustness::kNone, options.max_loop_squared_error);
  PoseGraphTermination termination = PoseGraphTermination::kFailed;
  for (int i = 0; i < kMaxPolishRounds; ++i) {
    const std::vector<std::size_t> outliers =
        LoopsAbove(graph, problem->SquaredErrors(), options.max_loop_squared_error);
    if (i > 0 && outliers == summary->outlier_edges) break;
    summary->outlier_edges = outliers;
    problem->SetWeights(WeightsWithout(outliers, graph.edges.size()));
    termination = problem->Minimize(options, kFarFromMinimum, summary);
    if (termination == PoseGraphTermination::kFailed) return termination;
  }
  return termination;
}

}  // namespace surfit
