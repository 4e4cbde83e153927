#pragma once

#include <ceres/cost_function.h>
#include <ceres/loss_function.h>
#include <ceres/problem.h>

#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <numeric>
#include <optional>
#include <vector>

#include "cost_functions/pose_manifold.h"
#include "optimization/pose_graph/pose_graph_names.h"
#include "surfit/optimization/pose_graph.h"

namespace surfit {

// Disjoint sets of poses.
class PoseSets {
 public:
  explicit PoseSets(std::size_t count) : parents_(count) {
    std::iota(parents_.begin(), parents_.end(), std::size_t{0});
  }

  // Smallest pose of the set.
  std::size_t Find(std::size_t pose) {
    while (parents_[pose] != pose) pose = parents_[pose] = parents_[parents_[pose]];
    return pose;
  }

  // Returns false if both poses are in one set.
  bool Join(std::size_t a, std::size_t b) {
    a = Find(a), b = Find(b);
    if (a == b) return false;
    parents_[std::max(a, b)] = std::min(a, b);
    return true;
  }

 private:
  std::vector<std::size_t> parents_;
};

// Poses chained along a spanning forest of the graph.
struct ChainedPoses {
  std::vector<Rigid3d> world_from_pose;
  // Roots of the trees: all fixed poses, and the first pose of each component without a fixed pose.
  std::vector<bool> roots;
  // Roots that fix the gauge: roots of components without a prior, and fixed poses.
  std::vector<bool> held;
  std::vector<std::size_t> component;  // first pose of the component of each pose
};

// Chains the measurements from the roots. Uses loop closures only for poses that odometry does not
// reach. Roots keep their input poses.
ChainedPoses ChainPoses(const PoseGraph& graph);

struct StartPoses {
  std::vector<Rigid3d> world_from_pose;
  // Poses with values that the edges do not determine: see ChordalPoses().
  std::vector<std::size_t> undetermined_rotations, undetermined_positions;
};

// Chordal initial poses from two linear systems. They do not depend on the drift. First, the
// matrices R_i minimise the sum of k |R_b - R_a R_ab|^2 over all edges, and are then projected to
// rotations. Second, the translations minimise the sum of k' |t_b - t_a - R_a t_ab|^2. k and k' are
// the mean information of rotation and translation. Poses of `fixed` do not move. Edges with
// positive k (k') divide the poses into connected sets. In a set without a fixed pose, the first
// pose keeps its given rotation (translation). Returns std::nullopt if a system cannot be solved.
// Carlone et al.: Initialization techniques for 3D SLAM, ICRA 2015, IV.B.
std::optional<StartPoses> ChordalPoses(const PoseGraph& graph, const std::vector<bool>& fixed);

// Moves each component with priors and without a fixed pose as a rigid body. The target is its
// first prior with rotation information. Without such a prior, the targets are all positions
// (Kabsch).
void AlignWithPriors(const PoseGraph& graph, const ChainedPoses& chained,
                     std::vector<Rigid3d>* world_from_pose);

// Initial trust-region radii of Levenberg-Marquardt. kFarFromMinimum is the default of Ceres, and
// faster from odometry poses. kNearMinimum is almost undamped. It saves ten iterations from
// chordal poses of a sphere graph with 10,000 poses.
inline constexpr double kFarFromMinimum = 1e4, kNearMinimum = 1e10;

// Kernel of a loop closure with a weight that can change between solver runs. See
// LoopRobustnessNames() for the kernels, where squared_error is s.
struct LoopLoss final : ceres::LossFunction {
  void Evaluate(double squared_error, double rho[3]) const override;

  double weight = 1;
  LoopRobustness kernel = LoopRobustness::kNone;
  double max_squared_error = 0;  // c^2
};

// Rotation part of the error of edges.
enum class RotationError {
  kRotationVector,  // documented error
  kQuaternion,      // ChordalRelativePose, for initial poses with large errors
};

class PoseGraphProblem {
 public:
  // Starts at `world_from_pose`, and not at the poses of the graph. Both vectors have one value per
  // pose. Held poses, and poses without edges, do not move. Keeps a reference to the graph.
  PoseGraphProblem(const PoseGraph& graph, const std::vector<Rigid3d>& world_from_pose,
                   const std::vector<bool>& held,
                   RotationError rotation_error = RotationError::kRotationVector);

  // Minimises the weighted cost by Levenberg-Marquardt from the current poses. The poses stay
  // unchanged after a failure. Appends the iterations to `summary` and counts a round. Other
  // members of `summary` do not change.
  PoseGraphTermination Minimize(const PoseGraphOptions& options, double initial_radius,
                                PoseGraphSummary* summary);

  // Weights of all edges, in [0, 1], in the order of the graph. Initially 1. Odometry edges ignore
  // their weights.
  void SetWeights(const std::vector<double>& weights);
  // Sets the kernel of all loop closures, and resets their weights to 1. kNone, kGnc and kAuto: the
  // squared error.
  void SetKernel(LoopRobustness kernel, double max_squared_error);

  // Unweighted squared errors of all edges at the current poses: Mahalanobis distances.
  std::vector<double> SquaredErrors() const;
  // Sum of the squared errors of priors and positions.
  double PriorError() const;

  // Current poses.
  std::vector<Rigid3d> Poses() const;
  void SetPoses(const std::vector<Rigid3d>& world_from_pose);

  // Jacobian of the residuals of some edges, and of all priors, by the tangent vectors of the poses
  // that are not held.
  struct Linearization {
    Eigen::SparseMatrix<double> jacobian;
    std::vector<int> first_column;  // of each pose; -1: held, or without measurements
    std::vector<int> first_row;     // of each edge; -1: left out
    int edge_rows = 0;
  };
  Linearization Linearize(const std::vector<bool>& used_edges);

 private:
  void AddEdges(RotationError rotation_error);
  void AddPriors();
  int block_size() const;

  using Block = std::array<double, kPoseSize>;  // planar: the first three numbers
  std::vector<Block> blocks_;
  std::vector<LoopLoss> losses_;  // per edge
  std::vector<ceres::CostFunction*> costs_;
  std::vector<ceres::ResidualBlockId> edge_blocks_, prior_blocks_;
  const PoseGraph& graph_;
  std::vector<bool> held_;
  ProductPoseManifold manifold_;
  ceres::Problem problem_;  // last member: points to other members
};

// Sets held_count and component_sizes of the summary. component_sizes must be empty.
void DescribeGraph(const PoseGraph& graph, const ChainedPoses& chained, PoseGraphSummary* summary);

// Indices of the loop closures in graph.edges, ascending.
std::vector<std::size_t> LoopsOf(const PoseGraph& graph);

// Sum of the ranks of all information matrices without some edges, minus the number of unknowns. At
// least 0.
double DegreesOfFreedom(const PoseGraph& graph, const ChainedPoses& chained,
                        const std::vector<std::size_t>& left_out);

// Half the sum of squared errors without some edges.
double CountedCost(const PoseGraphProblem& problem, const std::vector<std::size_t>& left_out);
// Half the sum of squared errors, where loop closures have the kernel min(s, c^2).
double TruncatedCost(const PoseGraph& graph, const PoseGraphProblem& problem,
                     double max_squared_error);

}  // namespace surfit
