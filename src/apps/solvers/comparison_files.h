#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "apps/solvers/compare_solvers.h"
#include "apps/solvers/pose_problem.h"

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

// A row as an element of `rows` in comparison.json.
nlohmann::ordered_json ToJson(const ComparisonRow& row);

// comparison.csv and comparison.json: a line, or an element of `rows`, for each row; slam.csv and
// `slam` likewise, where SLAM ran. What does not apply is empty, or null. Throws InputError naming
// the file that cannot be written.
void WriteComparisonFiles(const Comparison& comparison, const std::string& folder);

// Writes comparison.html into the output folder, a page that needs no other file: times, shares
// that converged over the perturbation (where the truth is known), the loss at each iteration from
// one start on the grid's diagonal, and all figures. Writes nothing where nothing ran. Throws
// InputError naming the file if it cannot be written.
void WriteComparisonPage(const std::vector<ComparedRuns>& all,
                         const std::vector<std::string>& notes, const CompareOptions& options);

}  // namespace surfit
