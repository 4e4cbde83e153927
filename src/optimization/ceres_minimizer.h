#pragma once

#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <ceres/types.h>

#include <array>
#include <vector>

#include "cost_functions/pose_manifold.h"
#include "optimization/pose_graph_problem.h"

namespace surfit {

// Minimises by Ceres' Levenberg-Marquardt. The problem must live longer.
class CeresMinimizer final : public PoseGraphMinimizer {
 public:
  CeresMinimizer(ceres::SparseLinearAlgebraLibraryType backend, PoseGraphProblem* problem);

  PoseGraphTermination Minimize(const MinimizerOptions& options,
                                PoseGraphSummary* summary) override;

 private:
  // Scales the squared error of an edge by a weight that may change between solves.
  struct WeightLoss final : ceres::LossFunction {
    void Evaluate(double squared_error, double rho[3]) const override {
      rho[0] = problem->weights[edge] * squared_error;
      rho[1] = problem->weights[edge];
      rho[2] = 0;
    }
    const PoseGraphProblem* problem = nullptr;
    std::size_t edge = 0;
  };

  ceres::SparseLinearAlgebraLibraryType backend_;
  PoseGraphProblem* problem_;
  std::vector<std::array<double, kPoseSize>> blocks_;  // of the poses
  std::vector<WeightLoss> losses_;                     // an edge each
  ProductPoseManifold manifold_;
  ceres::Problem ceres_problem_;  // last: it points to the others
};

}  // namespace surfit
