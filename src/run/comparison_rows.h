#pragma once

#include <vector>

#include "run/pose_problem.h"
#include "surfit/run/compare_solvers.h"

namespace surfit {

// One run of a combination.
struct ComparedRun {
  int problem = 0;
  GridCell cell;
  SolveOutcome outcome;
  // From the truth, where it is known.
  std::optional<double> rotation_error_deg, translation_error_m;
  std::optional<bool> converged;
};

// What a combination did at a number of threads.
struct ComparedRuns {
  SolverCombination combination;
  int threads = 0;
  std::vector<ComparedRun> runs;
};

ComparedRun Compare(SolveOutcome outcome, const std::optional<Rigid3d>& truth,
                    const CompareOptions& options);

ComparisonRow RowOf(const ComparedRuns& runs);

// Share of the runs from a cell that converged; empty where there are none or the truth is unknown.
std::optional<double> ConvergedShare(const ComparedRuns& runs, const GridCell& cell);

// Runs SLAM over the options' sequence with every combination, into folders of <output>/slam.
std::vector<SlamComparisonRow> CompareSlam(
    const CompareOptions& options, const std::atomic<bool>& interrupted,
    const std::function<void(const CompareProgress&)>& progress);

}  // namespace surfit
