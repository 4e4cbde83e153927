#include "optimization/pose_graph/optimize_pose_graph.h"

#include <cmath>

#include "core/trace.h"
#include "optimization/pose_graph/robust_loops.h"
#include "optimization/pose_graph/several_starts.h"
#include "surfit/core/options.h"

namespace surfit {
namespace {

// Maximum initial rotation error for the error kRotationVector, whose cost has a ridge at pi, rad.
constexpr double kLargeRotation = 1;

StartPoses GivenPoses(const PoseGraph& graph) {
  StartPoses start;
  for (const PoseGraphPose& pose : graph.poses)
    start.world_from_pose.push_back(pose.world_from_pose);
  return start;
}

double PriorCost(const PoseGraph& graph, const std::vector<Rigid3d>& poses) {
  PoseGraph priors;
  priors.priors = graph.priors;
  priors.positions = graph.positions;
  for (const Rigid3d& pose : poses) priors.poses.push_back({0, pose});
  return Cost(priors);
}

// Returns the initial poses, or std::nullopt if the chordal initialisation has no solution.
std::optional<StartPoses> Start(PoseGraphStart way, const PoseGraph& graph,
                                const ChainedPoses& chained) {
  std::optional<StartPoses> start = StartPoses{chained.world_from_pose, {}, {}};
  if (way == PoseGraphStart::kGiven) start = GivenPoses(graph);
  if (way == PoseGraphStart::kChordal) start = ChordalPoses(graph, chained.roots);
  if (!start || (graph.priors.empty() && graph.positions.empty())) return start;
  std::vector<Rigid3d> aligned = start->world_from_pose;
  AlignWithPriors(graph, chained, &aligned);
  if (PriorCost(graph, aligned) < PriorCost(graph, start->world_from_pose)) {
    start->world_from_pose = aligned;
  }
  return start;
}

double LargestRotation(const PoseGraph& graph, const std::vector<Rigid3d>& poses) {
  double largest = 0;
  for (const PoseGraphEdge& edge : graph.edges) {
    const Eigen::Quaterniond error = poses[edge.a].rotation.conjugate() * poses[edge.b].rotation *
                                     edge.a_from_b.rotation.conjugate();
    largest = std::max(largest, RotationAngle<double>(error));
  }
  return largest;
}

PoseGraphTermination Solve(const PoseGraph& graph, const PoseGraphOptions& options,
                           const ChainedPoses& chained, const StartPoses& start,
                           PoseGraphProblem* problem, PoseGraphSummary* summary) {
  const StageTimer timer("solve", TraceSlice::kNoFrame, &summary->solve_ms);
  const auto way = ValueOf("start", options.start, kPoseGraphStarts);
  const bool is_plain =
      ValueOf("loop_robustness", options.loop_robustness, kLoopRobustness) == LoopRobustness::kNone;
  if (is_plain && way != PoseGraphStart::kChordal && !graph.planar &&
      LargestRotation(graph, start.world_from_pose) > kLargeRotation) {
    PoseGraphProblem smooth(graph, start.world_from_pose, chained.held, RotationError::kQuaternion);
    PoseGraphOptions first = options;
    first.min_relative_cost_change = std::max(options.min_relative_cost_change, 1e-6);
    if (smooth.Minimize(first, kFarFromMinimum, summary) != PoseGraphTermination::kFailed) {
      problem->SetPoses(smooth.Poses());
    }
  }
  const bool is_near = way == PoseGraphStart::kChordal && start.undetermined_rotations.empty() &&
                       start.undetermined_positions.empty() && graph.priors.empty() &&
                       graph.positions.empty();
  return SolveRobustly(graph, options, is_near ? kNearMinimum : kFarFromMinimum, problem, summary);
}

}  // namespace

void Finish(const PoseGraph& graph, const PoseGraphOptions& options,
            const PoseGraphProblem& problem, GraphAttempt* attempt) {
  PoseGraphSummary& summary = attempt->summary;
  summary.final_cost = CountedCost(problem, summary.outlier_edges);
  summary.truncated_cost = TruncatedCost(graph, problem, options.max_loop_squared_error);
  summary.loop_error_limit = options.max_loop_squared_error;
  if (!std::isfinite(summary.final_cost)) summary.termination = PoseGraphTermination::kFailed;
  attempt->world_from_pose = problem.Poses();
}

GraphAttempt OptimizeOnce(const PoseGraph& graph, const PoseGraphOptions& options,
                          const ChainedPoses& chained) {
  GraphAttempt attempt;
  PoseGraphSummary& summary = attempt.summary;
  summary.start = options.start;
  summary.loop_robustness = options.loop_robustness;
  std::optional<StageTimer> timer(std::in_place, "initialize", TraceSlice::kNoFrame,
                                  &summary.initialize_ms);
  const auto start = Start(ValueOf("start", options.start, kPoseGraphStarts), graph, chained);
  if (!start) return attempt;
  summary.undetermined_rotations = start->undetermined_rotations;
  summary.undetermined_positions = start->undetermined_positions;
  PoseGraphProblem problem(graph, start->world_from_pose, chained.held);
  timer.reset();
  summary.initial_cost = CountedCost(problem, {});
  summary.termination = Solve(graph, options, chained, *start, &problem, &summary);
  Finish(graph, options, problem, &attempt);
  return attempt;
}

void DescribeGraph(const PoseGraph& graph, const ChainedPoses& chained, PoseGraphSummary* summary) {
  summary->held_count = std::count(chained.held.begin(), chained.held.end(), true);
  std::vector<std::size_t> sizes(graph.poses.size(), 0);
  for (const std::size_t component : chained.component) ++sizes[component];
  for (const std::size_t size : sizes) {
    if (size > 0) summary->component_sizes.push_back(size);
  }
}

std::vector<std::size_t> LoopsOf(const PoseGraph& graph) {
  std::vector<std::size_t> loops;
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    if (graph.edges[i].loop) loops.push_back(i);
  }
  return loops;
}

double CountedCost(const PoseGraphProblem& problem, const std::vector<std::size_t>& left_out) {
  std::vector<double> counted = problem.SquaredErrors();
  for (const std::size_t i : left_out) counted[i] = 0;
  return std::accumulate(counted.begin(), counted.end(), problem.PriorError()) / 2;
}

double TruncatedCost(const PoseGraph& graph, const PoseGraphProblem& problem,
                     double max_squared_error) {
  std::vector<double> errors = problem.SquaredErrors();
  for (const std::size_t i : LoopsOf(graph)) errors[i] = std::min(errors[i], max_squared_error);
  return std::accumulate(errors.begin(), errors.end(), problem.PriorError()) / 2;
}

PoseGraphSummary OptimizePoseGraph(const PoseGraphOptions& options, PoseGraph* graph) {
  Validate(options);
  graph->Validate();
  const ChainedPoses chained = ChainPoses(*graph);
  GraphAttempt best;
  const auto robustness = ValueOf("loop_robustness", options.loop_robustness, kLoopRobustness);
  const bool is_chordal =
      ValueOf("start", options.start, kPoseGraphStarts) == PoseGraphStart::kChordal;
  if (robustness == LoopRobustness::kAuto || (robustness == LoopRobustness::kGnc && is_chordal)) {
    best = OptimizeFromSeveralStarts(*graph, options, chained);
  } else {
    best = OptimizeOnce(*graph, options, chained);
  }
  PoseGraphSummary& summary = best.summary;
  summary.sparse_backend = options.sparse_backend;
  summary.given_cost = Cost(*graph);
  summary.loop_count = LoopsOf(*graph).size();
  DescribeGraph(*graph, chained, &summary);
  if (!summary.Succeeded()) return summary;
  for (std::size_t i = 0; i < graph->poses.size(); ++i) {  // held poses stay bitwise identical
    if (!chained.held[i]) graph->poses[i].world_from_pose = best.world_from_pose[i];
  }
  return summary;
}

}  // namespace surfit
