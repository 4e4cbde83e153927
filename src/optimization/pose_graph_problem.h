#pragma once

#include <memory>
#include <vector>

#include "cost_functions/analytic_relative_pose.h"
#include "surfit/optimization/optimize_pose_graph.h"

namespace surfit {

// A pose graph while it is optimised. The graph must live longer.
struct PoseGraphProblem {
  PoseGraphProblem(const PoseGraph& graph_, const std::vector<Rigid3d>& world_from_pose_,
                   const std::vector<bool>& held_);

  // Of each edge at the present poses, unweighted.
  std::vector<double> SquaredErrors() const;

  const PoseGraph& graph;
  std::vector<Rigid3d> world_from_pose;  // at present
  std::vector<bool> held;                // poses that do not move, among them those on no edge
  std::vector<std::unique_ptr<const AnalyticRelativePose>> costs;  // of each edge
  std::vector<double> weights;                                     // of their squared errors
};

// How Levenberg-Marquardt is to go on.
struct MinimizerOptions {
  // Ceres' default. Steps are damped by the diagonal of J^T J divided by this.
  static constexpr double kFarFromMinimum = 1e4;
  // Nearly those of Gauss-Newton. With more damping, the directions that long chains bend in most
  // easily take ten more iterations on a sphere of 10,000 poses.
  static constexpr double kNearMinimum = 1e10;

  double initial_radius = kFarFromMinimum;
  int max_iterations = 0;
  double min_relative_cost_change = 0;
};

// Minimises the weighted cost of a problem, as often as its weights change.
class PoseGraphMinimizer {
 public:
  virtual ~PoseGraphMinimizer() = default;

  // From the present poses, which move unless it fails. Adds its iterations to the summary.
  virtual PoseGraphTermination Minimize(const MinimizerOptions& options,
                                        PoseGraphSummary* summary) = 0;
};

}  // namespace surfit
