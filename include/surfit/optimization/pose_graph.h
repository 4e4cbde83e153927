#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
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

// Measured pose of a sensor on a pose, for example of a total station. Its error (w [rad], v [m])
// is the rotation vector and the translation of
//   E = world_from_sensor^-1 world_from_pose pose_from_sensor.
struct PoseGraphPrior {
  std::size_t pose = 0;  // index of a pose
  Rigid3d pose_from_sensor;
  Rigid3d world_from_sensor;
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Identity();
};

// Measured position of a sensor on a pose, for example of a GPS antenna. Its error (m) is
//   e = world_from_pose sensor_in_pose - sensor_in_world.
struct PoseGraphPosition {
  std::size_t pose = 0;  // index of a pose
  Eigen::Vector3d sensor_in_pose = Eigen::Vector3d::Zero();
  Eigen::Vector3d sensor_in_world = Eigen::Vector3d::Zero();
  Eigen::Matrix3d information = Eigen::Matrix3d::Identity();
};

// Returns whether a matrix is finite, symmetric and positive semidefinite. Eigenvalues down to
// -3e-5 of the largest eigenvalue are accepted, because files store 6 digits.
bool IsInformation(const Eigen::Matrix<double, 6, 6>& matrix);
bool IsInformation(const Eigen::Matrix3d& matrix);

// Poses and measurements.
struct PoseGraph {
  std::vector<PoseGraphPose> poses;
  std::vector<PoseGraphEdge> edges;
  std::vector<PoseGraphPrior> priors;
  std::vector<PoseGraphPosition> positions;
  // All poses and measurements are in SE(2): z = 0, and rotations are about z. Information is 0
  // outside of (rotation about z, x, y). The graph is solved in SE(2), with 3 unknowns per pose.
  bool planar = false;

  // Throws InputError that names the pose or edge, for these errors:
  // - ids that are not unique
  // - poses and measurements that are not finite or have no unit quaternion
  // - measurements with a missing pose, and edges with two equal poses
  // - measurements whose information is not accepted by IsInformation()
  // - planar graphs with a pose, measurement or information outside of SE(2), beyond 1e-9 rad or m
  void Validate() const;
};

// Selection of odometry edges. All other edges are loop closures.
// - "consecutive": edges between neighbours in the order of ids. Ids may have gaps.
// - "spanning_tree": edges of a spanning forest, the first ones in the order of the edges
// - "none": no edge
std::vector<std::string> OdometryNames();

// Sets PoseGraphEdge::loop of all edges. Indices are not checked. Throws InputError for an unknown
// name.
void SelectOdometry(const std::string& odometry, PoseGraph* graph);

// Sets all poses that are not fixed by chaining measurements along a spanning forest. Prefers
// odometry edges. The first pose of each component without a fixed pose keeps its pose.
void ChainPosesOf(PoseGraph* graph);

// Returns (w, v)^T information (w, v) of the error of an edge. It has a chi-square distribution
// with 6 degrees of freedom (3 in SE(2)) if the information is correct. Requires valid indices of
// poses.
double SquaredError(const PoseGraph& graph, const PoseGraphEdge& edge);

double SquaredError(const PoseGraph& graph, const PoseGraphPrior& prior);
double SquaredError(const PoseGraph& graph, const PoseGraphPosition& position);

// Returns half the sum of SquaredError() of all edges, priors and positions, including outliers.
double Cost(const PoseGraph& graph);

// Sparse linear solvers of Ceres in this build, the default first: "suite_sparse" (if Ceres has
// it and SURFIT_SUITESPARSE is on), "eigen_sparse". Throws InputError if Ceres has neither.
std::vector<std::string> SparseBackendNames();

// Initial poses:
// - "given": poses of the graph
// - "odometry": poses of ChainPosesOf(). Loop closures are used for poses without odometry only.
// - "chordal": rotations by linear least squares over the matrices of all edges, then translations
//   (Carlone et al.: Initialization techniques for 3D SLAM, ICRA 2015, IV.B). Poses without
//   rotation or translation information keep the given values.
// Components with priors are aligned with their priors, if this lowers the cost of the priors.
std::vector<std::string> PoseGraphStartNames();

// Treatment of outlier loop closures, with the squared error s of a loop closure and c^2 =
// max_loop_squared_error. Odometry, priors and positions always have the kernel s.
// - "none": all loop closures have the kernel s
// - "gnc": rejects outliers by graduated non-convexity with the kernel min(s, c^2) (Yang et al.,
//   RA-L 2020). GNC with the start "chordal" also runs from odometry, because outliers can fold
//   chordal poses, and repeats with smaller limits: see PoseGraphSummary::loop_error_limit. The
//   result with the smallest truncated cost is used.
// - "dcs": s for s <= c^2, else 3 c^2 - 4 c^4 / (c^2 + s) (Agarwal et al., ICRA 2013)
// - "huber": s for s <= c^2, else 2 c sqrt(s) - c^2
// - "cauchy": c^2 log(1 + s / c^2)
// - "geman_mcclure": c^2 s / (c^2 + s)
// - "auto": the smallest PoseGraphSummary::truncated_cost of several methods and starts
// "none" has no outliers. The outliers of "gnc" have the final weight 0, those of other methods
// have s > c^2 at the end.
std::vector<std::string> LoopRobustnessNames();

// Options of OptimizePoseGraph(). Construction throws as SparseBackendNames().
struct PoseGraphOptions {
  std::string sparse_backend = SparseBackendNames().front();
  std::string start = "chordal";         // one of PoseGraphStartNames()
  std::string loop_robustness = "none";  // one of LoopRobustnessNames()
  // Loop closures with a larger SquaredError() are outliers. 99.9 % of correct loop closures are
  // below the default (chi-square, 6 degrees of freedom).
  double max_loop_squared_error = 22.457744;
  // Maximum number of Levenberg-Marquardt iterations, and convergence threshold.
  int max_iterations = 200;
  double min_relative_cost_change = 1e-11;
  // Both limits for the rounds of "gnc" except the final round. "auto", and "gnc" with the start
  // "chordal", try several initial poses. Their rounds have at most 10 iterations and a threshold
  // of at least 1e-3.
  int max_round_iterations = 100;
  double min_round_cost_change = 1e-5;

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
  int round = 0;                   // solver run
  double cost = 0;                 // with the weights of the round, also of rejected steps
  double step_norm = 0;            // norm of the change of all parameters
  double gradient_norm = 0;        // norm of the gradient in the tangent space
  double trust_region_radius = 0;  // after the step
  bool accepted = false;           // the step was taken; true for iteration 0
  double time_ms = 0;              // duration of this iteration
};

// Result of OptimizePoseGraph(). After a failure, costs that were not computed are 0.
struct PoseGraphSummary {
  PoseGraphTermination termination = PoseGraphTermination::kFailed;
  std::string sparse_backend;
  std::string start, loop_robustness;  // of the result; empty if all attempts failed
  double given_cost = 0;               // Cost() of the input graph, all edges
  double initial_cost = 0;             // cost of the initial poses, all edges
  double final_cost = 0;               // final cost, without outliers
  // Final cost in which the squared error of each loop closure is at most loop_error_limit.
  double truncated_cost = 0;
  // Largest squared error of an inlier loop closure. It is max_loop_squared_error * min(1, 4 f) for
  // "auto", and for "gnc" from "chordal". The variance factor f is the chi-square of the inliers
  // over its degrees of freedom. Otherwise the limit is max_loop_squared_error. Example: the
  // information of a graph states 10 times the standard deviation of its residuals. Then f is 0.01.
  double loop_error_limit = 0;
  std::vector<PoseGraphIteration> iterations;
  int round_count = 0;  // number of Levenberg-Marquardt runs
  // Number of constant poses: fixed poses, and the first pose of each component without fixed
  // poses, priors and positions.
  std::size_t held_count = 0;
  // Number of poses of each component, in the order of its first pose.
  std::vector<std::size_t> component_sizes;
  std::size_t loop_count = 0;
  // Outlier loop closures: ascending indices of edges. Empty for "none".
  std::vector<std::size_t> outlier_edges;
  // Indices of poses whose chordal rotation or position is not determined by the edges. They start
  // from the given values.
  std::vector<std::size_t> undetermined_rotations, undetermined_positions;
  double initialize_ms = 0, solve_ms = 0;

  bool Succeeded() const { return termination != PoseGraphTermination::kFailed; }
};

// Moves the poses of the graph to a local minimum of the cost with the kernels of
// `loop_robustness`. Runs on one thread: equal graphs give bitwise identical poses. `graph` must
// not be null. A solver failure is a termination, not an exception. An empty graph converges.
// Throws InputError for an invalid graph or invalid options.
PoseGraphSummary OptimizePoseGraph(const PoseGraphOptions& options, PoseGraph* graph);

// Comparison of the residuals of an optimised graph with their information matrices.
struct PoseGraphFit {
  double chi_square = 0;  // sum of SquaredError() without outliers
  // Sum of the ranks of all information matrices without outliers, minus the number of unknowns. 6
  // (E - V + 1) for a connected graph of E edges of full rank and V poses, 3 (E - V + 1) in SE(2).
  double degrees_of_freedom = 0;
  double p_value = 1;  // probability of a larger chi_square
  // Squared errors over degrees of freedom of odometry edges and of accepted loop closures. The
  // degrees of freedom of a class are its rank minus the trace of its part of the hat matrix J (J^T
  // J)^-1 J^T, which is estimated. 0: class with at most 0.5 degrees of freedom, or singular J^T J.
  double odometry_ratio = 0, loop_ratio = 0;
  bool doubtful = false;
  std::string reason;  // empty: no doubt
};

// Tests whether the residuals of a graph are plausible, after a successful OptimizePoseGraph().
// Upper tail only, because public graphs often state too little information. See fit_test.cc for
// the criteria.
PoseGraphFit TestFit(const PoseGraph& graph, const PoseGraphSummary& summary);

// Marginal covariances of chosen poses of an optimised graph without its outliers: diagonal blocks
// of (J^T J)^-1. A block refers to (w [rad], v [m]) with the true rotation exp(w) R and the true
// translation t + v, both in the world frame. It is 0 for held poses. In SE(2), it is 0 outside of
// (rotation about z, x, y). Returns std::nullopt if the edges do not determine all poses. Throws
// InputError for an index without a pose.
std::optional<std::vector<Eigen::Matrix<double, 6, 6>>> MarginalCovariances(
    const PoseGraph& graph, const PoseGraphSummary& summary, const std::vector<std::size_t>& poses);

}  // namespace surfit
