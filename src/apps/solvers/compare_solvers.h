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

// What to compare, and on what: exactly one of synthetic_points, sequence, the two clouds, replay
// and run.
struct CompareOptions {
  int synthetic_points = 0;  // so many known pairs; 0 = none
  double noise_m = 0;        // standard deviation of each coordinate of their targets

  SequenceOptions sequence;  // its path empty = none; stride is not used
  int pairs = 4;             // of its frames, evenly spread; 0 = none, with slam
  int gap = 10;              // frames from source to target
  bool slam = false;         // also run SLAM over all frames with each combination

  std::string source, target;  // clouds: PLY or PCD
  std::string truth;           // their target_from_source, tx,ty,tz,qx,qy,qz,qw; empty = unknown

  // A frame's folder that surfit_slam kept (SlamRunOptions::dump_failures). It starts at the pose
  // that tracking started at, with tracking's options in place of preprocess and icp.
  std::string replay;

  // Folder of a run of surfit_slam over the sequence: a round of joint refinement of its keyframes
  // (Refine()) is solved to the least cost, from the run's poses, with the surfels and the kernel
  // of a last round. Keyframes are RefineRunOptions', at most so many (0 = no limit).
  std::string run;
  int max_keyframes = 120;

  std::string output;  // folder for tables and pictures; made if missing

  // By name; empty = all that make sense.
  std::vector<std::string> solvers, linear_solvers, residuals, associations;
  std::vector<int> threads = {2};  // one row for each

  // Each registration starts at the truth (the identity where it is unknown), turned about the
  // target's origin and shifted, each with each, about and along random axes.
  std::vector<double> rotations_deg = {1, 5, 10, 20, 45};
  std::vector<double> translations_m = {0.01, 0.05, 0.1, 0.3, 1};
  std::uint64_t seed = 1;
  // Nearer to the truth counts as converged.
  double max_rotation_error_deg = 1;
  double max_translation_error_m = 0.02;

  PreprocessOptions preprocess;
  IcpOptions icp;  // its solver, residual and association are the compared ones

  void Visit(OptionVisitor& visitor);
};

// One way to solve for a pose.
struct SolverCombination {
  std::string solver;
  std::string linear_solver;  // of ceres_per_point, and of refinement's ceres; else empty
  std::string residual;
  std::string association;  // "known" for known pairs, and of refinement

  // "solver", or "solver (linear_solver)".
  std::string SolverTitle() const;
};

// What a combination did on all starts: medians over the runs that converged (that did not fail,
// where the truth is unknown). Where none did, of points, times and iterations those over all runs;
// cost and errors are empty then, as is what does not apply.
struct ComparisonRow {
  SolverCombination combination;
  int points = 0;  // of the source, on the finest level; observations of refinement
  int threads = 0;
  int runs = 0;
  std::optional<double> build_ms;      // of a solve: what Ceres is given
  std::optional<double> linearize_ms;  // once; with the association where both are done at once
  std::optional<double> solve_ms;      // of a solve, without build_ms
  double total_ms = 0;                 // from the start to the final pose, all included
  double iterations = 0;  // steps of ICP or, over known pairs, linearisations; steps of refinement
  // Of refinement: solve_ms by iterations, and the most memory that is resident while it builds and
  // solves, beyond what is before.
  std::optional<double> iteration_ms, memory_bytes;
  std::optional<double> final_cost;  // 1/2 sum of rho(s)
  std::optional<double> rotation_error_deg, translation_error_m;
  std::optional<double> converged_share;  // of all runs
  std::string termination;  // the most frequent one of all runs; empty over known pairs
};

// What SLAM made of the sequence with a combination. Empty is what needs ground truth, or a map
// with a point.
struct SlamComparisonRow {
  SolverCombination combination;
  int threads = 0;
  int frames = 0, frames_lost = 0;
  std::optional<double> ate_m;        // RMSE
  double frame_ms = 0, track_ms = 0;  // medians
  std::size_t map_points = 0;
  // From the points of this map to the planes of their nearest ones in the map of the first row
  // with the same residual and association, and the share of that map that has a point of this one
  // within 1 cm.
  std::optional<double> surface_distance_mean_m, surface_distance_p90_m, shared_surface;
};

// How far a comparison has come.
struct CompareProgress {
  std::string unit;  // "run", or "frame" of SLAM
  int done = 0;
  int total = 0;
  double elapsed_s = 0;  // since the first of these
};

// The outcome of a comparison.
struct Comparison {
  std::vector<ComparisonRow> rows;
  std::vector<SlamComparisonRow> slam;
  std::vector<std::string> notes;  // what the user should know of the rows
};

// Runs every combination from every start and writes comparison.csv, comparison.json and a page of
// charts, comparison.html, into the output folder; of SLAM slam.csv, a part of comparison.json, and
// what each run writes (RunSlam()) in a folder of slam/. Combinations take
// turns, so that what else the machine does meets all of them alike. ceres_per_point is slow: over
// known pairs it runs from a few of the starts only, elsewhere only if it is asked for by name, and
// then on the first pair. When `interrupted` becomes true, what has been run so far is written.
// Throws InputError for bad options or data that cannot be read.
Comparison CompareSolvers(const CompareOptions& options, const std::atomic<bool>& interrupted,
                          const std::function<void(const CompareProgress&)>& progress);

}  // namespace surfit
