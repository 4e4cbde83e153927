#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "surfit/frame/preprocess.h"
#include "surfit/io/sequence.h"
#include "surfit/registration/icp.h"

namespace surfit {

class OptionVisitor;

// Options of CompareSolvers(). Exactly one input is set: synthetic_points, sequence, source and
// target, replay, or run (with its sequence).
struct CompareOptions {
  int synthetic_points = 0;  // number of random points with known correspondences; 0: none
  double noise_m = 0;        // standard deviation of the coordinates of target points

  SequenceOptions sequence;  // empty path: none; stride is not used
  int pairs = 4;             // number of frame pairs, evenly spread; 0: none, with slam
  int gap = 10;              // frames from source to target
  bool slam = false;         // also run SLAM on all frames with each combination

  std::string source, target;  // clouds: PLY or PCD
  std::string truth;           // target_from_source: tx,ty,tz,qx,qy,qz,qw; empty: unknown

  // Folder of a failed registration (SlamRunOptions::dump_failures). Its initial pose is used, and
  // its options replace `preprocess` and `icp`.
  std::string replay;

  // Output folder of surfit_slam for the sequence. One round of joint refinement (Refine()) is
  // minimised, from the poses of the run, with the surfels and the kernel of the last round.
  // Keyframes are chosen as by RefineRunOptions, at most max_keyframes (0: no limit).
  std::string run;
  int max_keyframes = 120;

  std::string output;  // output folder, created if missing

  // Names to compare; empty: all supported names.
  std::vector<std::string> solvers, linear_solvers, residuals, associations;
  std::vector<int> threads = {2};  // one row per number

  // Perturbations of the initial pose. Each registration starts at the truth (the identity if it is
  // unknown), rotated about the origin of the target and translated. Axes are random. Each rotation
  // is combined with each translation.
  std::vector<double> rotations_deg = {1, 5, 10, 20, 45};
  std::vector<double> translations_m = {0.01, 0.05, 0.1, 0.3, 1};
  std::uint64_t seed = 1;
  // Maximum errors of a converged run.
  double max_rotation_error_deg = 1;
  double max_translation_error_m = 0.02;

  PreprocessOptions preprocess;
  IcpOptions icp;  // solver, residual and association are set per combination

  void Visit(OptionVisitor& visitor);
};

// Solver for the pose with its variants.
struct SolverCombination {
  std::string solver;
  std::string linear_solver;  // of ceres_per_point, and of ceres in refinement; otherwise empty
  std::string residual;
  std::string association;  // "known" for known correspondences and for refinement

  // "solver" or "solver (linear_solver)".
  std::string SolverTitle() const;
};

// Results of a combination over all initial poses: medians over the converged runs, or over the
// successful runs if the truth is unknown. If no run converged, points, times and iterations are
// medians over all runs, and cost and errors are empty. Values that do not apply are empty.
struct ComparisonRow {
  SolverCombination combination;
  int points = 0;  // of the source on the finest level; refinement: observations
  int threads = 0;
  int runs = 0;
  std::optional<double> build_ms;  // time to build a Ceres problem
  // Time of a linearisation. Includes the association if both are one step of the solver.
  std::optional<double> linearize_ms;
  std::optional<double> solve_ms;  // time of a solve, without build_ms
  double total_ms = 0;             // from the initial to the final pose
  double iterations = 0;  // steps of ICP or refinement; known correspondences: linearisations
  // Refinement only: solve_ms per iteration, and increase of the peak resident memory.
  std::optional<double> iteration_ms, memory_bytes;
  std::optional<double> final_cost;  // 1/2 sum of rho(s)
  std::optional<double> rotation_error_deg, translation_error_m;
  std::optional<double> converged_ratio;  // converged runs / runs
  std::string termination;  // most frequent value of all runs; empty for known correspondences
};

// Results of SLAM with a combination. Values that need ground truth or a non-empty map are
// std::nullopt without them.
struct SlamComparisonRow {
  SolverCombination combination;
  int threads = 0;
  int frames = 0, frames_lost = 0;
  std::optional<double> ate_m;        // RMSE
  double frame_ms = 0, track_ms = 0;  // medians
  std::size_t map_points = 0;
  // Distances from the points of this map to the planes of the nearest points of a reference map.
  // The reference map is the map of the first row with the same residual and association.
  // `shared_surface` is the ratio of reference points within 1 cm of this map.
  std::optional<double> surface_distance_mean_m, surface_distance_p90_m, shared_surface;
};

struct CompareProgress {
  std::string unit;  // "run", or "frame" for SLAM
  int done = 0;
  int total = 0;
  double elapsed_s = 0;  // since the first run or frame
};

struct Comparison {
  std::vector<ComparisonRow> rows;
  std::vector<SlamComparisonRow> slam;
  std::vector<std::string> notes;  // remarks on the rows
};

// Runs all combinations from all initial poses. Writes comparison.csv, comparison.json and
// comparison.html (charts) into the output folder. SLAM runs add slam.csv, an entry of
// comparison.json, and their results (RunSlam()) in folders of slam/. Combinations alternate, so
// that other load of the machine affects all combinations. The slow solver ceres_per_point runs
// only on the first pair, from the initial poses on the diagonal of the grid. It runs only if
// `solvers` names it, or if correspondences are known. If `interrupted` becomes true, the results
// so far are written. Throws InputError for invalid options or unreadable data.
Comparison CompareSolvers(const CompareOptions& options, const std::atomic<bool>& interrupted,
                          const std::function<void(const CompareProgress&)>& progress);

}  // namespace surfit
