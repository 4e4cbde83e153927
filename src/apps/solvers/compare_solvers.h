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

// Exactly one input must be set: synthetic_points, sequence, source and target, replay, or run
// with sequence.
struct CompareOptions {
  int synthetic_points = 0;  // number of random points with known correspondences; 0: off
  // Standard deviation per coordinate of these points, also in the error model. 0: exact points,
  // with floor_sigma_m in the error model.
  double noise_m = 0;

  SequenceOptions sequence;  // empty path: none; `stride` is not used
  int pairs = 4;             // number of frame pairs, evenly spread; 0: none, requires `slam`
  int gap = 10;              // frames between source and target of a pair
  bool slam = false;         // also run SLAM with each combination

  std::string source, target;  // clouds: PLY or PCD
  std::string truth;           // target_from_source: tx,ty,tz,qx,qy,qz,qw; empty: unknown

  // Folder of a failed registration (SlamRunOptions::dump_failures). Its initial pose and
  // options are used instead of the perturbations, `preprocess` and `icp`.
  std::string replay;

  // Output folder of surfit_slam for the sequence. The problem is one round of Refine() from
  // the poses of the run, with the final kernel width. Keyframes: RefineRunOptions, at most
  // max_keyframes (0: no limit).
  std::string run;
  int max_keyframes = 120;

  std::string output;  // output folder, created if missing

  // Names to compare; empty: all supported names.
  std::vector<std::string> solvers, linear_solvers, residuals, associations;
  std::vector<int> threads = {2};  // numbers of threads, one row each

  // Perturbations of the initial pose, which is the truth or, if unknown, the identity. The
  // rotation is about the origin of the target. Axes are random. Each rotation is combined
  // with each translation.
  std::vector<double> rotations_deg = {1, 5, 10, 20, 45};
  std::vector<double> translations_m = {0.01, 0.05, 0.1, 0.3, 1};
  std::uint64_t seed = 1;

  PreprocessOptions preprocess;
  IcpOptions icp;  // except solver, residual and association

  void Visit(OptionVisitor& visitor);
};

// Names of a compared method.
struct SolverCombination {
  std::string solver;
  std::string linear_solver;  // only for ceres_per_point, and for ceres in refinement
  std::string residual;
  std::string association;  // "known" for synthetic points and refinement

  // "solver" or "solver (linear_solver)".
  std::string SolverTitle() const;
};

// Results of a combination: medians over the converged runs or, if the truth is unknown, the
// successful runs. If there are none, points, times and iterations are medians over all runs,
// and cost and errors are std::nullopt. Values that do not apply are std::nullopt.
struct ComparisonRow {
  SolverCombination combination;
  int points = 0;  // source points on the finest level; refinement: observations
  int threads = 0;
  int runs = 0;
  std::optional<double> build_ms;  // construction of a Ceres problem
  // Data association, except for known correspondences, and one linearisation.
  std::optional<double> linearize_ms;
  std::optional<double> solve_ms;  // one solve, without build_ms
  double total_ms = 0;             // from the initial to the final pose
  double iterations = 0;           // steps; synthetic points: linearisations
  // Only refinement: solve_ms per iteration, and increase of the peak resident memory.
  std::optional<double> iteration_ms, memory_bytes;
  std::optional<double> final_cost;  // 1/2 sum of rho(s)
  std::optional<double> rotation_error_deg, translation_error_m;
  std::optional<double> converged_ratio;
  std::optional<double> converged_low, converged_high;  // 95 % interval, see WilsonInterval()
  std::string termination;  // most frequent value; empty for synthetic points
};

// Results of SLAM with a combination. ate_m is std::nullopt without ground truth. The surface
// values are std::nullopt if a map is empty.
struct SlamComparisonRow {
  SolverCombination combination;
  int threads = 0;
  int frames = 0, frames_lost = 0;
  std::optional<double> ate_m;        // RMSE
  double frame_ms = 0, track_ms = 0;  // mean times per frame
  std::size_t map_points = 0;
  // Distances from points of this map to tangent planes of a reference map. The reference map
  // is the map of the first row with equal residual and association. `shared_surface`: ratio
  // of reference points within 1 cm of this map.
  std::optional<double> surface_distance_mean_m, surface_distance_p90_m, shared_surface;
};

// Progress of CompareSolvers(). `done` and `total` are in the given unit.
struct CompareProgress {
  std::string unit;  // "run", or "frame" for SLAM
  int done = 0;
  int total = 0;
  double elapsed_s = 0;
};

struct Comparison {
  std::vector<ComparisonRow> rows;
  std::vector<SlamComparisonRow> slam;
  std::vector<std::string> notes;  // explanations for the reader
};

// Runs all combinations from all initial poses. Writes comparison.csv, comparison.json and
// comparison.html into the output folder. With `slam`, also writes slam.csv, an entry of
// comparison.json, and the results of RunSlam() below slam/. Combinations alternate, so that
// other load of the machine affects all of them. The slow solver ceres_per_point runs only for
// synthetic points, or if `solvers` names it. It uses the first pair, and initial poses with
// equal indices of rotation and translation. If `interrupted` becomes true, writes the results
// so far. `progress` must not be empty. Throws InputError for invalid options, unreadable data,
// or results that cannot be written.
Comparison CompareSolvers(const CompareOptions& options, const std::atomic<bool>& interrupted,
                          const std::function<void(const CompareProgress&)>& progress);

}  // namespace surfit
