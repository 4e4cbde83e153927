#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "surfit/geometry/rigid3.h"

namespace surfit {

class OptionVisitor;

// A node of a pose graph.
struct PoseGraphPose {
  std::int64_t id = 0;  // its name outside, for files and messages
  Rigid3d world_from_pose;
  bool fixed = false;  // known: never moved
};

// A measurement between two poses. Its error is the left increment (w [rad], v [m]) in the frame of
// a that takes the measured pose to the estimate: log of (world_from_a^-1 world_from_b)
// a_from_b^-1.
struct PoseGraphEdge {
  std::size_t a = 0, b = 0;  // indices of poses
  Rigid3d a_from_b;
  // Of that increment (1/rad^2, 1/m^2), as IcpResult::information is for a = target, b = source;
  // 0 along what was not measured.
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Identity();
  bool loop = false;  // may be wrong; others, the odometry, are trusted
};

// Whether a matrix is finite, symmetric and positive semidefinite, but for rounding to 6 digits as
// in files.
bool IsInformation(const Eigen::Matrix<double, 6, 6>& matrix);

// Poses and what was measured between them.
struct PoseGraph {
  std::vector<PoseGraphPose> poses;
  std::vector<PoseGraphEdge> edges;

  // Throws InputError naming the pose or edge if ids are not unique, an edge's poses do not exist
  // or are the same one, numbers are not finite, or IsInformation() does not hold.
  void Validate() const;
};

// (w, v)^T information (w, v) of the edge's error: chi-square distributed with 6 degrees of freedom
// if the information is right.
double SquaredError(const PoseGraph& graph, const PoseGraphEdge& edge);

// 1/2 the sum of these.
double Cost(const PoseGraph& graph);

// Of Ceres' solvers for sparse systems, those that this build may use: "suite_sparse" (where Ceres
// has it and SURFIT_SUITESPARSE is on), "eigen_sparse". The first is the default.
std::vector<std::string> SparseBackendNames();

// "given": the graph's poses; "odometry": poses chained along edges that are no loops, from a held
// one; "chordal": rotations that agree best with all edges in the least squares of their matrices,
// then translations (Carlone et al.: Initialization techniques for 3D SLAM, ICRA 2015, IV.B).
std::vector<std::string> PoseGraphInitializationNames();

// "none": all edges count; "gnc": loops that do not fit the others are left out, found by
// graduated non-convexity with truncated least squares (Yang et al., RA-L 2020). It begins at
// odometry where "chordal" is asked for, which wrong loops would mislead.
std::vector<std::string> LoopRobustnessNames();

// How a pose graph is optimised.
struct PoseGraphOptions {
  std::string sparse_backend = SparseBackendNames().front();
  std::string initialization = "chordal";  // one of PoseGraphInitializationNames()
  std::string loop_robustness = "none";    // one of LoopRobustnessNames()
  // A loop of a larger SquaredError() is wrong: 999 of 1000 right ones are below (chi-square, 6
  // degrees of freedom).
  double max_loop_squared_error = 22.457744;
  int max_iterations = 200;                 // of Levenberg-Marquardt, in each round of "gnc"
  double min_relative_cost_change = 1e-11;  // ends it

  void Visit(OptionVisitor& visitor);
};

enum class PoseGraphTermination {
  kConverged,      // the cost no longer changes
  kMaxIterations,  // the iterations were used up; the poses are the best so far
  kFailed,         // failure: the solver gave up; the poses are as they were
};

// "converged", "max_iterations", "failed".
std::string ToString(PoseGraphTermination termination);

// The state after a step of Levenberg-Marquardt; the first is before any.
struct PoseGraphIteration {
  int round = 0;          // of "gnc"; 0 is the only one of "none"
  double cost = 0;        // as minimised: in rounds of "gnc" loops have weights
  double step_norm = 0;   // rad and m together
  bool accepted = false;  // the step made the cost less
  double time_ms = 0;
};

// The outcome of an optimisation.
struct PoseGraphSummary {
  PoseGraphTermination termination = PoseGraphTermination::kFailed;
  std::string sparse_backend;
  double given_cost = 0;    // Cost() of the graph as it came, all edges
  double initial_cost = 0;  // where Levenberg-Marquardt began, all edges
  double final_cost = 0;    // at the end, of the edges that count
  std::vector<PoseGraphIteration> iterations;
  int round_count = 0;         // solves by Levenberg-Marquardt
  std::size_t held_count = 0;  // poses that were not moved: fixed ones, and one in each part of the
                               // graph that has none and that no edge joins to others
  std::size_t loop_count = 0;
  std::vector<std::size_t> outlier_edges;  // loops left out as wrong: indices of edges, ascending
  double initialize_ms = 0, solve_ms = 0;

  bool Succeeded() const { return termination != PoseGraphTermination::kFailed; }
};

// Moves the graph's poses to the least Cost(), on one thread, so that the same graph gives the same
// poses bit for bit. Throws InputError for an impossible graph or options; failure to solve is a
// termination, not an error.
PoseGraphSummary OptimizePoseGraph(const PoseGraphOptions& options, PoseGraph* graph);

}  // namespace surfit
