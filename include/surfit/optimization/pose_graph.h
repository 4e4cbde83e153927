#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "surfit/geometry/rigid3.h"

namespace surfit {

class OptionVisitor;

// Vertex of a pose graph.
struct PoseGraphPose {
  std::int64_t id = 0;  // id in files and messages
  Rigid3d world_from_pose;
  bool fixed = false;  // constant during optimisation
};

// Relative pose measurement. Its error is a left perturbation (w [rad], v [m]) in frame a: the
// rotation vector and the translation of world_from_a^-1 world_from_b a_from_b^-1.
struct PoseGraphEdge {
  std::size_t a = 0, b = 0;  // indices of poses
  Rigid3d a_from_b;
  // Information of the error (1/rad^2, 1/m^2), as IcpResult::information with a = target and b
  // = source. 0 along unobservable directions.
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Identity();
  bool loop = false;  // loop closure, may be an outlier; false: odometry
};

// Returns whether a matrix is finite, symmetric and positive semidefinite. Eigenvalues down to
// -3e-5 of the largest eigenvalue are accepted, because files store 6 digits.
bool IsInformation(const Eigen::Matrix<double, 6, 6>& matrix);

// Poses and relative pose measurements.
struct PoseGraph {
  std::vector<PoseGraphPose> poses;
  std::vector<PoseGraphEdge> edges;

  // Throws InputError that names the pose or edge, for these errors:
  // - ids that are not unique
  // - poses and measurements that are not finite or have no unit quaternion
  // - edges with a missing pose or with two equal poses
  // - edges whose information is not accepted by IsInformation()
  void Validate() const;
};

// Returns (w, v)^T information (w, v) of the error of an edge. With correct information, it has
// a chi-square distribution with 6 degrees of freedom. Requires valid pose indices.
double SquaredError(const PoseGraph& graph, const PoseGraphEdge& edge);

// Returns half the sum of SquaredError() of all edges, including outliers.
double Cost(const PoseGraph& graph);

// Sparse linear solvers of Ceres in this build, the default first: "suite_sparse" (if Ceres has
// it and SURFIT_SUITESPARSE is on), "eigen_sparse". Throws InputError if Ceres has neither.
std::vector<std::string> SparseBackendNames();

// Initial poses:
// - "given": poses of the graph
// - "odometry": poses chained along odometry edges, from the held poses
//   (PoseGraphSummary::held_count). Loop closures are used for poses without odometry only.
// - "chordal": rotations by linear least squares over the matrices of all edges, then translations
//   (Carlone et al.: Initialization techniques for 3D SLAM, ICRA 2015, IV.B)
std::vector<std::string> PoseGraphInitializationNames();

// Treatment of outlier loop closures:
// - "none": all loop closures are used
// - "gnc": rejects outliers by graduated non-convexity with truncated least squares (Yang et al.,
//   RA-L 2020). The initialization "chordal" is replaced by "odometry", because outliers would
//   distort the chordal initial poses.
std::vector<std::string> LoopRobustnessNames();

// Options of OptimizePoseGraph(). Construction throws as SparseBackendNames().
struct PoseGraphOptions {
  std::string sparse_backend = SparseBackendNames().front();
  std::string initialization = "chordal";  // one of PoseGraphInitializationNames()
  std::string loop_robustness = "none";    // one of LoopRobustnessNames()
  // For "gnc": loop closures with a larger SquaredError() are outliers. Default: 99.9 %
  // quantile of correct loop closures (chi-square, 6 degrees of freedom).
  double max_loop_squared_error = 22.457744;
  // Maximum number of Levenberg-Marquardt iterations, and convergence threshold. Rounds of
  // "gnc" before the final round have at most 10 iterations and a threshold of at least 1e-3.
  int max_iterations = 200;
  double min_relative_cost_change = 1e-11;

  void Visit(OptionVisitor& visitor);
};

// Termination of OptimizePoseGraph().
enum class PoseGraphTermination {
  kConverged,      // relative change of the cost below the threshold
  kMaxIterations,  // success with the last accepted poses
  kFailed,         // solver failure, or no "chordal" initial poses; the graph is unchanged
};

// "converged", "max_iterations", "failed".
std::string ToString(PoseGraphTermination termination);

// Iteration of Levenberg-Marquardt. Iteration 0 of a round is the state before its first step.
struct PoseGraphIteration {
  int round = 0;          // round of "gnc"; 0 for "none"
  double cost = 0;        // cost with the loop weights of the round
  double step_norm = 0;   // norm of the change of all quaternions and translations (m)
  bool accepted = false;  // false: the step was rejected
  double time_ms = 0;     // duration of this iteration
};

// Result of OptimizePoseGraph(). After a failure, costs that were not computed are 0.
struct PoseGraphSummary {
  PoseGraphTermination termination = PoseGraphTermination::kFailed;
  std::string sparse_backend;
  double given_cost = 0;    // Cost() of the input graph, all edges
  double initial_cost = 0;  // cost of the initial poses, all edges
  double final_cost = 0;    // cost of the final poses, without outliers
  std::vector<PoseGraphIteration> iterations;
  int round_count = 0;  // number of Levenberg-Marquardt runs
  // Number of held poses, which do not move: fixed poses, and the first pose of each connected
  // component without a fixed pose.
  std::size_t held_count = 0;
  std::size_t loop_count = 0;
  // Outlier loop closures of "gnc": ascending indices of edges. Empty for "none".
  std::vector<std::size_t> outlier_edges;
  double initialize_ms = 0, solve_ms = 0;

  bool Succeeded() const { return termination != PoseGraphTermination::kFailed; }
};

// Moves the poses of the graph to a local minimum of Cost(), without outlier loop closures. Runs on
// one thread: equal graphs give bitwise identical poses. `graph` must not be null. A solver failure
// is a termination, not an exception. An empty graph converges. Throws InputError for an invalid
// graph or invalid options.
PoseGraphSummary OptimizePoseGraph(const PoseGraphOptions& options, PoseGraph* graph);

}  // namespace surfit
