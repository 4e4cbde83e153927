#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "apps/solvers/compare_solvers.h"
#include "apps/solvers/pose_problem.h"

namespace surfit {

struct ComparedRun {
  int problem = 0;  // index in PoseProblems
  PerturbationCell cell;
  SolveOutcome outcome;
  // std::nullopt: the truth is unknown.
  std::optional<double> rotation_error_deg, translation_error_m;
  std::optional<bool> converged;
};

struct ComparedRuns {
  SolverCombination combination;
  int threads = 0;
  std::vector<ComparedRun> runs;
};

// Limits of the errors of a converged run.
constexpr double kMaxRotationError_deg = 1, kMaxTranslationError_m = 0.02;

// Computes errors and convergence (success, and errors below the limits). `problem` and `cell` are
// not set.
ComparedRun Compare(SolveOutcome outcome, const std::optional<Rigid3d>& truth);

// Medians of the runs, see ComparisonRow. Requires at least one run.
ComparisonRow RowOf(const ComparedRuns& runs);

// Numbers of runs with a known truth.
struct RunCounts {
  int runs = 0;
  int converged = 0;

  // Converged runs / runs. std::nullopt without runs.
  std::optional<double> Ratio() const;
};

RunCounts CountsOf(const ComparedRuns& runs, const PerturbationCell& cell);

// 95 % confidence interval of the probability of convergence (Wilson: Probable inference, the law
// of succession, and statistical inference, 1927). {0, 1} without runs.
std::pair<double, double> WilsonInterval(const RunCounts& counts);

// Runs SLAM with each combination. Results are in <output>/slam. If interrupted, returns the rows
// so far. `progress` must not be empty.
std::vector<SlamComparisonRow> CompareSlam(
    const CompareOptions& options, const std::atomic<bool>& interrupted,
    const std::function<void(const CompareProgress&)>& progress);

// Element of `rows` in comparison.json.
nlohmann::ordered_json ToJson(const ComparisonRow& row);

// Writes comparison.csv, comparison.json and, with SLAM rows, slam.csv. Missing values are empty
// (CSV) or null. Throws InputError with the file name.
void WriteComparisonFiles(const Comparison& comparison, const std::string& folder);

// Writes comparison.html, a self-contained page: rows, ratio of converged runs per perturbation,
// and loss per iteration from one initial pose. Writes nothing without runs. Throws InputError
// with the file name.
void WriteComparisonPage(const std::vector<ComparedRuns>& all,
                         const std::vector<std::string>& notes, const CompareOptions& options);

}  // namespace surfit
