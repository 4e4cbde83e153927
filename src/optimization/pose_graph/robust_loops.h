#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "optimization/pose_graph/optimize_pose_graph.h"

namespace surfit {

// Minimises the cost with the kernel of options.loop_robustness, which is not "auto", from the
// current poses of the problem. `graph` is the graph of the problem. `initial_radius` is the
// trust-region radius for "none"; other methods use kFarFromMinimum. Sets the outliers of the
// summary, and appends iterations and rounds. Returns kFailed if a solver run fails.
PoseGraphTermination SolveRobustly(const PoseGraph& graph, const PoseGraphOptions& options,
                                   double initial_radius, PoseGraphProblem* problem,
                                   PoseGraphSummary* summary);

// Lowers the truncated cost: solves without the outliers and classifies the loop closures again,
// until the outliers do not change, or after 20 rounds. Results are as for SolveRobustly().
PoseGraphTermination PolishTruncated(const PoseGraph& graph, const PoseGraphOptions& options,
                                     PoseGraphProblem* problem, PoseGraphSummary* summary);

// Weights of graduated non-convexity with truncated least squares. The cost of a loop closure
// changes from a convex surrogate to min(e^2, c^2) of its squared error e^2. The control parameter
// mu grows by a factor of 1.4 per round. Yang, Antonante, Tzoumas, Carlone: Graduated Non-Convexity
// for Robust Spatial Perception, RA-L 2020, eq. 12 to 14 and remark 5, where e^2 is called r^2.
class LoopWeights {
 public:
  // `max_squared_error` is c^2. `squared_errors` are the errors of all loop closures before the
  // first round.
  LoopWeights(double max_squared_error, const std::vector<double>& squared_errors)
      : max_squared_error_(max_squared_error) {
    double largest = 0;
    for (const double error : squared_errors) largest = std::max(largest, error);
    all_fit_ = largest <= max_squared_error;
    if (!all_fit_) mu_ = max_squared_error / (2 * largest - max_squared_error);
  }

  // Returns the weights, in [0, 1], for the current mu, and then increases mu.
  std::vector<double> Update(const std::vector<double>& squared_errors) {
    std::vector<double> weights(squared_errors.size(), 1);
    if (all_fit_) return weights;
    std::transform(squared_errors.begin(), squared_errors.end(), weights.begin(),
                   [&](double error) { return Weight(error); });
    mu_ *= kGrowth;
    return weights;
  }

 private:
  static constexpr double kGrowth = 1.4;

  double Weight(double squared_error) const {
    if (squared_error >= (mu_ + 1) / mu_ * max_squared_error_) return 0;
    if (squared_error <= mu_ / (mu_ + 1) * max_squared_error_) return 1;
    return std::clamp(std::sqrt(max_squared_error_ * mu_ * (mu_ + 1) / squared_error) - mu_, 0.,
                      1.);
  }

  double max_squared_error_;
  double mu_ = 0;
  bool all_fit_ = false;  // no initial error exceeds c^2: all weights stay 1
};

// True if all weights are 0 or 1, also without weights.
inline bool AreBinary(const std::vector<double>& weights) {
  return std::all_of(weights.begin(), weights.end(), [](double w) { return w == 0 || w == 1; });
}

}  // namespace surfit
