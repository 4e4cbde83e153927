#include "optimization/pose_graph/several_starts.h"

#include <algorithm>
#include <utility>

#include "core/trace.h"
#include "optimization/pose_graph/robust_loops.h"

namespace surfit {
namespace {

// Method and start of one attempt of "auto".
struct Candidate {
  const char *loop_robustness, *start;
  bool for_gnc;  // also an attempt of "gnc" from "chordal"
};
constexpr Candidate kCandidates[] = {{"gnc", "odometry", true},
                                     {"dcs", "odometry", false},
                                     {"geman_mcclure", "odometry", false},
                                     {"gnc", "chordal", true}};
// Limits of the rounds of "gnc" of an attempt. Polish() ends each attempt in a minimum.
constexpr int kAttemptIterations = 10;
constexpr double kAttemptCostChange = 1e-3;
// GNC from odometry repeats with a smaller limit while the variance factor decreases below this
// ratio.
constexpr double kFactorDecrease = 0.7;
constexpr int kMaxRepeats = 6;
// Errors of correct loop closures have heavier tails than a normal distribution. The limit accepts
// a loop closure with twice the standard deviation of the other loop closures.
constexpr double kTailFactor = 4;
// First limits of the trials of AcceptTails(), relative to the largest limit. 0: no first run. A
// rejected loop closure of a long odometry chain can exceed the largest limit by far. The chain
// bends at a small cost. Example: CSAIL has a squared error of 26, which costs 2.6 if accepted.
constexpr double kFirstLimits[] = {0, 1, 10};

// The information matrices of many graphs understate the accuracy. Then wrong loop closures that
// bend the odometry a little fit max_loop_squared_error, and the truncated cost can be smaller with
// them. Therefore, the limits of the compared costs are scaled by the variance factor. It is the
// chi-square over its degrees of freedom (Baarda: A testing procedure for use in geodetic networks,
// 1968). The factor is at most 1, so the limit never increases.
class SeveralStarts {
 public:
  SeveralStarts(const PoseGraph& graph, const PoseGraphOptions& options,
                const ChainedPoses& chained)
      : graph_(graph), options_(options), chained_(chained) {}

  GraphAttempt Run() {
    const bool only_gnc = options_.loop_robustness == "gnc";
    for (const Candidate& candidate : kCandidates) {
      if (candidate.for_gnc || !only_gnc) Try(candidate, 1);
    }
    double factor = 1;
    for (int i = 0; i < kMaxRepeats && factor_ < kFactorDecrease * factor; ++i) {
      factor = factor_;
      Try(kCandidates[0], factor);
    }
    if (factor_ < 1 && best_.summary.Succeeded()) AcceptTails();
    best_.summary.iterations = std::move(iterations_);
    best_.summary.round_count = rounds_;
    best_.summary.initialize_ms = initialize_ms_;
    best_.summary.solve_ms = solve_ms_;
    return std::move(best_);
  }

 private:
  PoseGraphOptions WithLimit(double factor) const {
    PoseGraphOptions options = options_;
    options.max_loop_squared_error *= factor;
    return options;
  }

  // Adds the iterations and times of an attempt to those of all attempts.
  void Count(PoseGraphSummary* summary) {
    for (PoseGraphIteration iteration : summary->iterations) {
      iteration.round += rounds_;
      iterations_.push_back(iteration);
    }
    rounds_ += summary->round_count;
    initialize_ms_ += summary->initialize_ms;
    solve_ms_ += summary->solve_ms;
  }

  // Lets the attempt end in a minimum of the truncated cost.
  void Polish(const PoseGraphOptions& options, GraphAttempt* attempt) const {
    PoseGraphProblem problem(graph_, attempt->world_from_pose, chained_.held);
    {
      const StageTimer timer("solve", TraceSlice::kNoFrame, &attempt->summary.solve_ms);
      attempt->summary.termination = PolishTruncated(graph_, options, &problem, &attempt->summary);
    }
    Finish(graph_, options, problem, attempt);
  }

  // Accepts correct loop closures that the smallest limit rejects. They deviate more if they are
  // rejected. Therefore, trials begin with larger limits. Keeps the smallest truncated cost.
  void AcceptTails() {
    std::vector<GraphAttempt> trials;
    double factor = factor_;
    for (const double first_limit : kFirstLimits) {
      GraphAttempt trial = best_;
      trial.summary.iterations.clear();
      trial.summary.round_count = 0;
      trial.summary.initialize_ms = trial.summary.solve_ms = 0;
      if (first_limit > 0) Polish(WithLimit(first_limit), &trial);
      if (trial.summary.Succeeded()) {
        const double own = first_limit > 0 ? VarianceFactor(trial.summary) : factor_;
        Polish(WithLimit(std::min(1., kTailFactor * own)), &trial);
      }
      Count(&trial.summary);
      if (!trial.summary.Succeeded()) continue;
      factor = std::min(factor, VarianceFactor(trial.summary));
      trials.push_back(std::move(trial));
    }
    const double common = std::min(1., kTailFactor * factor);
    const auto best = std::min_element(trials.begin(), trials.end(), [&](auto& a, auto& b) {
      return CostOf(a, common) < CostOf(b, common);
    });
    if (best != trials.end()) best_ = std::move(*best);
  }

  // Few accepted loop closures do not show the accuracy of the information: the factor is 1.
  double VarianceFactor(const PoseGraphSummary& summary) const {
    const double freedom = DegreesOfFreedom(graph_, chained_, summary.outlier_edges);
    if (2 * summary.outlier_edges.size() > LoopsOf(graph_).size() || !(freedom > 0)) return 1;
    return std::min(1., 2 * summary.final_cost / freedom);
  }

  double CostOf(const GraphAttempt& attempt, double factor) const {
    const PoseGraphProblem problem(graph_, attempt.world_from_pose, chained_.held);
    return TruncatedCost(graph_, problem, factor * options_.max_loop_squared_error);
  }

  // Keeps the attempt with the smallest truncated cost. The first one of equal attempts wins.
  void Try(const Candidate& candidate, double limit_factor) {
    PoseGraphOptions one = WithLimit(limit_factor);
    one.loop_robustness = candidate.loop_robustness;
    one.start = candidate.start;
    one.max_round_iterations = std::min(options_.max_round_iterations, kAttemptIterations);
    one.min_round_cost_change = std::max(options_.min_round_cost_change, kAttemptCostChange);
    GraphAttempt attempt = OptimizeOnce(graph_, one, chained_);
    if (attempt.summary.Succeeded()) Polish(WithLimit(limit_factor), &attempt);
    Count(&attempt.summary);
    if (!attempt.summary.Succeeded()) return;
    const double factor = VarianceFactor(attempt.summary);
    if (best_.summary.Succeeded()) {
      const double common = std::min(factor, factor_);
      if (!(CostOf(attempt, common) < CostOf(best_, common))) return;
    }
    best_ = std::move(attempt);
    factor_ = factor;
  }

  const PoseGraph& graph_;
  const PoseGraphOptions& options_;
  const ChainedPoses& chained_;
  GraphAttempt best_;
  double factor_ = 1;  // variance factor of the best attempt
  std::vector<PoseGraphIteration> iterations_;
  int rounds_ = 0;
  double initialize_ms_ = 0, solve_ms_ = 0;
};

}  // namespace

GraphAttempt OptimizeFromSeveralStarts(const PoseGraph& graph, const PoseGraphOptions& options,
                                       const ChainedPoses& chained) {
  return SeveralStarts(graph, options, chained).Run();
}

}  // namespace surfit
