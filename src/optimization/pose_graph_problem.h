#pragma once

#include <ceres/cost_function.h>
#include <ceres/loss_function.h>
#include <ceres/problem.h>

#include <array>
#include <vector>

#include "cost_functions/pose_manifold.h"
#include "surfit/optimization/pose_graph.h"

namespace surfit {

// How far Levenberg-Marquardt's first steps may go: Ceres' default, and nearly as far as those of
// Gauss-Newton. Damped more, what long chains bend in most easily takes ten more iterations from
// chordal poses, on a sphere of 10,000; from odometry's it takes some less.
inline constexpr double kFarFromMinimum = 1e4, kNearMinimum = 1e10;

// A pose graph as Ceres' problem.
class PoseGraphProblem {
 public:
  // Poses that are held or on no edge do not move. The graph must live longer.
  PoseGraphProblem(const PoseGraph& graph, const std::vector<Rigid3d>& world_from_pose,
                   const std::vector<bool>& held);

  // Minimises the weighted cost by Levenberg-Marquardt from the present poses, which move unless it
  // fails. Adds its iterations to the summary.
  PoseGraphTermination Minimize(const PoseGraphOptions& options, double initial_radius,
                                PoseGraphSummary* summary);

  // A weight for each of graph.edges.
  void SetWeights(const std::vector<double>& weights);

  // Of each edge at the present poses, unweighted.
  std::vector<double> SquaredErrors() const;

  std::vector<Rigid3d> Poses() const;

 private:
  // Scales the squared error of an edge by a weight that may change between solves.
  struct WeightLoss final : ceres::LossFunction {
    void Evaluate(double squared_error, double rho[3]) const override {
      rho[0] = weight * squared_error;
      rho[1] = weight;
      rho[2] = 0;
    }
    double weight = 1;
  };

  std::vector<std::array<double, kPoseSize>> poses_;
  std::vector<WeightLoss> losses_;  // an edge each
  std::vector<const ceres::CostFunction*> costs_;
  const PoseGraph& graph_;
  ProductPoseManifold manifold_;
  ceres::Problem problem_;  // last: it points to the others
};

}  // namespace surfit
