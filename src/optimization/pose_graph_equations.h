#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "optimization/block_cholesky.h"
#include "optimization/pose_graph_problem.h"
#include "optimization/unknown_poses.h"

namespace surfit {

// A step of Levenberg-Marquardt: increments (w [rad], v [m]) of ProductPoseManifold for each
// unknown pose, and by how much the linearised cost falls.
struct PoseGraphStep {
  Eigen::VectorXd increments;
  double cost_decrease = 0;
};

// The normal equations J^T J d = -J^T r of a pose graph's weighted cost.
class PoseGraphEquations {
 public:
  explicit PoseGraphEquations(const PoseGraphProblem& problem);

  const UnknownPoses& unknowns() const { return unknowns_; }

  // At the problem's present poses and weights.
  void Linearize(const PoseGraphProblem& problem);

  // Damped by the diagonal divided by the radius; nothing if that is not positive definite.
  std::optional<PoseGraphStep> Solve(double radius);

 private:
  Eigen::VectorXd Damping(double radius) const;

  UnknownPoses unknowns_;
  BlockCholesky cholesky_;
  BlockMatrix matrix_;        // J^T J
  Eigen::VectorXd gradient_;  // J^T r
};

}  // namespace surfit
