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

// Relative pose measurement. Its error is the left perturbation (w [rad], v [m]) in the frame of a
// that transforms the measured pose into the estimate: the log of (world_from_a^-1 world_from_b)
// a_from_b^-1.
struct PoseGraphEdge {
  std::size_t a = 0, b = 0;  // indices of poses
  Rigid3d a_from_b;
  // Information of this perturbation (1/rad^2, 1/m^2), as IcpResult::information with a = target
  // and b = source. 0 along directions that were not measured.
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Identity();
  bool loop = false;  // loop closure, possibly an outlier; false: odometry, trusted
};

// Returns whether a matrix is finite, symmetric and positive semidefinite, up to rounding to 6
// digits as in files.
bool IsInformation(const Eigen::Matrix<double, 6, 6>& matrix);

// Poses and relative pose measurements.
struct PoseGraph {
  std::vector<PoseGraphPose> poses;
  std::vector<PoseGraphEdge> edges;

  // Throws InputError that names the pose or edge, for these errors: ids that are not unique, poses
  // that are not finite or have no unit quaternion, edges with a missing pose or with two equal
  // poses, and edges without a valid IsInformation().
  void Validate() const;
};

// Returns (w, v)^T information (w, v) of the error of an edge. It has a chi-square distribution
// with 6 degrees of freedom if the information is correct.
double SquaredError(const PoseGraph& graph, const PoseGraphEdge& edge);

// Returns half the sum of the squared errors of all edges.
double Cost(const PoseGraph& graph);

// Sparse linear solvers of Ceres in this build, the default first: "suite_sparse" (if Ceres has it
// and SURFIT_SUITESPARSE is on), "eigen_sparse". Throws InputError if Ceres has none of them.
std::vector<std::string> SparseBackendNames();

// Initial poses:
// - "given": poses of the graph
// - "odometry": poses chained along odometry edges, from a fixed pose
// - "chordal": rotations by linear least squares over the matrices of all edges, then translations
//   (Carlone et al.: Initialization techniques for 3D SLAM, ICRA 2015, IV.B)
std::vector<std::string> PoseGraphInitializationNames();

// Treatment of outlier loop closures:
// - "none": all loop closures are used
// - "gnc": rejects outliers by graduated non-convexity with truncated least squares (Yang et al.,
//   RA-L 2020). With "chordal", it starts from "odometry", because outliers would distort the
//   chordal initial poses.
std::vector<std::string> LoopRobustnessNames();

// Options of OptimizePoseGraph().
struct PoseGraphOptions {
  std::string sparse_backend = SparseBackendNames().front();
  std::string initialization = "chordal";  // one of PoseGraphInitializationNames()
  std::string loop_robustness = "none";    // one of LoopRobustnessNames()
  // Loop closures with a larger SquaredError() are outliers. 99.9 % of correct loop closures are
  // below the default (chi-square, 6 degrees of freedom).
  double max_loop_squared_error = 22.457744;
  int max_iterations = 200;                 // of Levenberg-Marquardt, per round of "gnc"
  double min_relative_cost_change = 1e-11;  // convergence threshold

  void Visit(OptionVisitor& visitor);
};

enum class PoseGraphTermination {
  kConverged,      // relative change of the cost below the threshold
  kMaxIterations,  // best poses so far
  kFailed,         // solver failure; the poses are unchanged
};

// "converged", "max_iterations", "failed".
std::string ToString(PoseGraphTermination termination);

// Iteration of Levenberg-Marquardt. Iteration 0 of a round is the state before its first step.
struct PoseGraphIteration {
  int round = 0;          // round of "gnc"; 0 for "none"
  double cost = 0;        // cost with the loop weights of the round
  double step_norm = 0;   // norm of the increments in rad and m
  bool accepted = false;  // the step reduced the cost
  double time_ms = 0;
};

// Result of OptimizePoseGraph().
struct PoseGraphSummary {
  PoseGraphTermination termination = PoseGraphTermination::kFailed;
  std::string sparse_backend;
  double given_cost = 0;    // Cost() of the input graph, all edges
  double initial_cost = 0;  // cost of the initial poses, all edges
  double final_cost = 0;    // final cost, without outliers
  std::vector<PoseGraphIteration> iterations;
  int round_count = 0;         // number of Levenberg-Marquardt runs
  std::size_t held_count = 0;  // poses that were held: fixed poses, and one pose per component of
                               // the graph without a fixed pose
  std::size_t loop_count = 0;
  std::vector<std::size_t> outlier_edges;  // outlier loop closures: ascending indices of edges
  double initialize_ms = 0, solve_ms = 0;

  bool Succeeded() const { return termination != PoseGraphTermination::kFailed; }
};

// Moves the poses of the graph to the minimum of Cost(), without outlier loop closures. Runs on one
// thread: the same graph gives bitwise identical poses. A solver failure is a termination, not an
// exception. Throws InputError for an invalid graph or invalid options.
PoseGraphSummary OptimizePoseGraph(const PoseGraphOptions& options, PoseGraph* graph);

}  // namespace surfit
