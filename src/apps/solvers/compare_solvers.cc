#include "apps/solvers/compare_solvers.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "apps/solvers/comparison_files.h"
#include "apps/solvers/pose_problem.h"
#include "io/files/output_folder.h"
#include "registration/solvers/pair_solver.h"
#include "run/results/tracking_dump.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

PoseProblems ProblemsOf(const CompareOptions& options) {
  if (options.synthetic_points > 0) return KnownPairsProblems(options);
  if (!options.source.empty()) return CloudProblems(options);
  if (!options.replay.empty()) return ReplayProblems(options);
  if (!options.run.empty()) return RefinementProblems(options);
  return FramePairProblems(options);
}

class ComparisonRunner {
 public:
  ComparisonRunner(const CompareOptions& options, const std::atomic<bool>& interrupted,
                   const std::function<void(const CompareProgress&)>& progress)
      : options_(options),
        interrupted_(interrupted),
        progress_(progress),
        problems_(ProblemsOf(options)),
        cells_(AllCells(static_cast<int>(options.rotations_deg.size()),
                        static_cast<int>(options.translations_m.size()))) {
    for (const SolverCombination& combination : SolverCombinations(options)) {
      for (const int threads : options.threads) all_.push_back({combination, threads, {}});
    }
    ForEach([&](int, const PerturbationCell&, ComparedRuns*) { ++total_; });
  }

  std::vector<ComparedRuns> Run() {
    std::optional<PoseProblem> problem;
    int made = -1;
    ForEach([&](int i, const PerturbationCell& cell, ComparedRuns* runs) {
      if (i != made) {
        problem = problems_.make(i);
        made = i;
      }
      RunOne(*problem, i, cell, runs);
      progress_({"run", ++done_, total_, 1e-3 * time_.Milliseconds()});
    });
    return std::move(all_);
  }

 private:
  // Calls f for each problem, initial pose and combination. Combinations alternate, so that all of
  // them run under equal conditions. Slow combinations run only on the first problem, from initial
  // poses with equal rotation and translation indices.
  template <typename F>
  void ForEach(const F& f) {
    for (int i = 0; i < problems_.count; ++i) {
      for (const PerturbationCell& cell : cells_) {
        for (ComparedRuns& runs : all_) {
          if (IsSlow(runs.combination) && (i > 0 || !cell.on_diagonal())) continue;
          if (interrupted_) return;
          f(i, cell, &runs);
        }
      }
    }
  }

  void RunOne(const PoseProblem& problem, int i, const PerturbationCell& cell,
              ComparedRuns* runs) const {
    const ThreadLimit limit(runs->threads);
    const auto seed = options_.seed + static_cast<std::uint64_t>(i) * cells_.size() +
                      cell.rotation * options_.translations_m.size() + cell.translation;
    const Rigid3d start =
        Perturbed(problem.center, options_.rotations_deg[cell.rotation] * M_PI / 180,
                  options_.translations_m[cell.translation], seed);
    ComparedRun run = Compare(problem.solve(runs->combination, start), problem.truth);
    run.problem = i;
    run.cell = cell;
    runs->runs.push_back(std::move(run));
  }

  const CompareOptions& options_;
  const std::atomic<bool>& interrupted_;
  const std::function<void(const CompareProgress&)>& progress_;
  const PoseProblems problems_;
  const std::vector<PerturbationCell> cells_;
  const Stopwatch time_;
  std::vector<ComparedRuns> all_;
  int total_ = 0, done_ = 0;
};

std::vector<std::string> NotesOf(const CompareOptions& options,
                                 const std::vector<ComparedRuns>& all) {
  std::vector<std::string> notes;
  if (!options.run.empty()) {
    notes.emplace_back(
        "memory is the increase of the peak resident memory while a solver builds and solves the "
        "problem");
    return notes;
  }
  bool slow = false;
  for (const ComparedRuns& runs : all) slow = slow || IsSlow(runs.combination);
  if (slow) {
    notes.emplace_back(
        "ceres_per_point ran only on the first pair, from the initial poses on the diagonal of the "
        "grid");
  } else if (options.solvers.empty()) {
    notes.emplace_back(
        "ceres_per_point did not run: set --solvers=ceres_per_point,... to run it on the first "
        "pair, "
        "from the initial poses on the diagonal of the grid");
  }
  if (!options.replay.empty()) {
    const TrackingDump dump = ReadTrackingDump(options.replay);
    notes.push_back(Concat("frame ", dump.frame, " was lost with ", dump.icp.solver, ", ",
                           dump.icp.residual, ", ", dump.icp.association, ", with termination ",
                           dump.termination));
    return notes;
  }
  for (const ComparedRuns& runs : all) {
    if (runs.runs.empty() || runs.runs.front().converged) continue;
    notes.emplace_back(
        "the truth is unknown: initial poses are close to the identity, and errors are not shown");
    break;
  }
  return notes;
}

}  // namespace

Comparison CompareSolvers(const CompareOptions& given, const std::atomic<bool>& interrupted,
                          const std::function<void(const CompareProgress&)>& progress) {
  Validate(given);
  CompareOptions options = given;
  if (!options.replay.empty() || !options.run.empty()) {
    options.rotations_deg = options.translations_m = {0};
  }
  const ThreadLimit limit(*std::max_element(options.threads.begin(), options.threads.end()));
  ComparisonRunner run(options, interrupted, progress);
  const OutputFolder owned(options.output,
                           {"comparison.csv", "comparison.json", "comparison.html", "slam.csv"});
  const std::vector<ComparedRuns> all = run.Run();
  Comparison comparison;
  for (const ComparedRuns& runs : all) {
    if (!runs.runs.empty()) comparison.rows.push_back(RowOf(runs));
  }
  if (options.slam) comparison.slam = CompareSlam(options, interrupted, progress);
  comparison.notes = NotesOf(options, all);
  WriteComparisonFiles(comparison, options.output);
  WriteComparisonPage(all, comparison.notes, options);
  return comparison;
}

}  // namespace surfit
