#pragma once

#include <ceres/cost_function.h>
#include <ceres/loss_function.h>
#include <ceres/problem.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "cost_functions/pose_manifold.h"
#include "surfit/optimization/pose_graph.h"

namespace surfit {

// Poses along a spanning forest of the graph.
struct ChainedPoses {
  std::vector<Rigid3d> world_from_pose;
  // Those where trees begin, which the gauge's freedom is taken from: all fixed poses, and the
  // first of each part of the graph that has none.
  std::vector<bool> held;
};

// Chains measurements from held poses on, along loops only where no odometry leads.
ChainedPoses ChainPoses(const PoseGraph& graph);

// Poses from two linear systems, whatever the drift: rotations R_i that minimise the sum of
// k |R_b - R_a R_ab|^2 over all edges as if they were any matrices, made rotations afterwards, then
// translations that minimise the sum of k' |t_b - t_a - R_a t_ab|^2; k, k' are the mean information
// of rotation and translation. Held poses stay. Nothing where a system cannot be solved. Carlone et
// al.: Initialization techniques for 3D SLAM, ICRA 2015, IV.B.
std::optional<std::vector<Rigid3d>> ChordalPoses(const PoseGraph& graph,
                                                 const std::vector<bool>& held);

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

// Graduated non-convexity with truncated least squares: min(e^2, c^2) of each loop's squared error
// e^2 is reached from a convex surrogate by a control parameter mu that grows by 1.4 a round. Yang,
// Antonante, Tzoumas, Carlone: Graduated Non-Convexity for Robust Spatial Perception, RA-L 2020,
// eq. 12 to 14 and remark 5; r^2 there is e^2 here.
class LoopWeights {
 public:
  // max_squared_error is c^2; squared_errors are those of all loops at the start. That is odometry
  // here, not the paper's minimum of all weights 1: wrong loops fold a trajectory so that it stays
  // folded.
  LoopWeights(double max_squared_error, const std::vector<double>& squared_errors)
      : max_squared_error_(max_squared_error) {
    double largest = 0;
    for (const double error : squared_errors) largest = std::max(largest, error);
    all_fit_ = largest <= max_squared_error;
    if (!all_fit_) mu_ = max_squared_error / (2 * largest - max_squared_error);
  }

  // The weights, from 0 to 1, at the present mu, which then grows.
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
  bool all_fit_ = false;  // no error is above the truncation from the start: all weights stay 1
};

// Every weight is 0 or 1.
inline bool AreBinary(const std::vector<double>& weights) {
  return std::all_of(weights.begin(), weights.end(), [](double w) { return w == 0 || w == 1; });
}

}  // namespace surfit
