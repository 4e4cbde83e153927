#pragma once

#include "optimization/pose_graph_equations.h"
#include "optimization/trust_region.h"

namespace surfit {

// Minimises by Levenberg-Marquardt as Ceres does, over BlockCholesky: the same steps but for
// rounding. The problem must live longer.
class BlockMinimizer final : public PoseGraphMinimizer {
 public:
  explicit BlockMinimizer(PoseGraphProblem* problem) : problem_(problem), equations_(*problem) {}

  PoseGraphTermination Minimize(const MinimizerOptions& options,
                                PoseGraphSummary* summary) override;

 private:
  // A step, and the cost after it.
  struct Attempt {
    double cost = 0, step_norm = 0;
    bool accepted = false, converged = false;
  };

  // Moves the poses if that makes the cost less.
  Attempt Try(double cost, double min_relative_cost_change, TrustRegion* region);

  PoseGraphProblem* problem_;
  PoseGraphEquations equations_;
};

}  // namespace surfit
