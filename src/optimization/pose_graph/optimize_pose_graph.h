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

// Initial poses along a spanning forest of the pose graph.
struct ChainedPoses {
  std::vector<Rigid3d> world_from_pose;
  // Roots of the trees, which fix the gauge: all fixed poses, and the first pose of each component
  // without a fixed pose.
  std::vector<bool> held;
};

// Chains the measurements from the roots. Uses loop closures only for poses that odometry does not
// reach. Roots keep their input poses.
ChainedPoses ChainPoses(const PoseGraph& graph);

// Chordal initial poses from two linear systems (Carlone et al.: Initialization techniques for 3D
// SLAM, ICRA 2015, IV.B). First, matrices R_i minimise sum k |R_b - R_a R_ab|^2 over all edges and
// are projected to rotations. Second, the translations minimise sum k' |t_b - t_a - R_a t_ab|^2. k
// and k': mean of the diagonal information of rotation and translation. (R_ab, t_ab) is
// PoseGraphEdge::a_from_b.
//
// `held`: one value per pose. Held poses keep their input values. Each component must have a held
// pose. Returns std::nullopt if a system cannot be solved.
std::optional<std::vector<Rigid3d>> ChordalPoses(const PoseGraph& graph,
                                                 const std::vector<bool>& held);

// Initial trust-region radii of Levenberg-Marquardt. kFarFromMinimum is the default of Ceres, and
// faster from odometry poses. kNearMinimum is almost undamped. It saves ten iterations from
// chordal poses of a sphere graph with 10,000 poses.
inline constexpr double kFarFromMinimum = 1e4, kNearMinimum = 1e10;

// Nonlinear least-squares problem of a pose graph, solved by Ceres on one thread. Not thread-safe.
class PoseGraphProblem {
 public:
  // Starts at `world_from_pose`, and not at the poses of the graph. Both vectors have one value per
  // pose. Held poses, and poses without edges, do not move. Keeps a reference to the graph.
  PoseGraphProblem(const PoseGraph& graph, const std::vector<Rigid3d>& world_from_pose,
                   const std::vector<bool>& held);

  // Minimises the weighted cost by Levenberg-Marquardt from the current poses. The poses stay
  // unchanged after a failure. Appends the iterations to `summary` and counts a round. Other
  // members of `summary` do not change.
  PoseGraphTermination Minimize(const PoseGraphOptions& options, double initial_radius,
                                PoseGraphSummary* summary);

  // Weights of all edges, in [0, 1], in the order of the graph. Initially 1. Odometry edges ignore
  // their weights.
  void SetWeights(const std::vector<double>& weights);

  // Unweighted squared errors of all edges at the current poses: Mahalanobis distances.
  std::vector<double> SquaredErrors() const;

  // Current poses.
  std::vector<Rigid3d> Poses() const;

 private:
  struct WeightLoss final : ceres::LossFunction {
    void Evaluate(double squared_error, double rho[3]) const override {
      rho[0] = weight * squared_error;
      rho[1] = weight;
      rho[2] = 0;
    }
    double weight = 1;
  };

  std::vector<std::array<double, kPoseSize>> poses_;
  std::vector<WeightLoss> losses_;
  std::vector<const ceres::CostFunction*> costs_;
  const PoseGraph& graph_;
  ProductPoseManifold manifold_;
  ceres::Problem problem_;  // last member: points to other members
};

// Weights of graduated non-convexity with truncated least squares. Source: Yang, Antonante,
// Tzoumas, Carlone: Graduated Non-Convexity for Robust Spatial Perception, RA-L 2020, eq. 12 to 14
// and remark 5. The cost of a squared error e^2 (r^2 in the paper) changes from a convex surrogate
// to min(e^2, c^2). The control parameter mu grows by a factor of 1.4 per round. Call Update() once
// per round, after the minimisation. If no initial error exceeds c^2, all weights stay 1.
class LoopWeights {
 public:
  // `max_squared_error`: c^2. `squared_errors`: loop closures at the initial poses. The paper
  // starts from the minimum with all weights 1. Here the initial poses are odometry poses,
  // because outliers can fold a trajectory irreversibly.
  LoopWeights(double max_squared_error, const std::vector<double>& squared_errors)
      : max_squared_error_(max_squared_error) {
    double largest = 0;
    for (const double error : squared_errors) largest = std::max(largest, error);
    all_fit_ = largest <= max_squared_error;
    if (!all_fit_) mu_ = max_squared_error / (2 * largest - max_squared_error);
  }

  // Returns the weights, in [0, 1], for the current mu, and then increases mu. `squared_errors`:
  // loop closures at the current poses, in the order of the constructor.
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

// Returns whether all weights are 0 or 1, so that GNC has converged.
inline bool AreBinary(const std::vector<double>& weights) {
  return std::all_of(weights.begin(), weights.end(), [](double w) { return w == 0 || w == 1; });
}

}  // namespace surfit
