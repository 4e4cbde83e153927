#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <tuple>

#include "apps/solvers/comparison_files.h"
#include "surfit/evaluation/trajectory_evaluation.h"

namespace surfit {
namespace {

template <typename F>
std::optional<double> Median(const std::vector<ComparedRun>& runs, const F& value_of) {
  std::vector<double> values;
  for (const ComparedRun& run : runs) {
    if (const std::optional<double> value = value_of(run)) values.push_back(*value);
  }
  if (values.empty()) return std::nullopt;
  return Quantile(values, 0.5);
}

template <typename Chosen>
RunCounts Count(const std::vector<ComparedRun>& runs, const Chosen& chosen) {
  RunCounts counts;
  for (const ComparedRun& run : runs) {
    if (!run.converged || !chosen(run)) continue;
    ++counts.runs;
    if (*run.converged) ++counts.converged;
  }
  return counts;
}

std::string MostFrequentTermination(const std::vector<ComparedRun>& runs) {
  std::map<std::string, int> counts;
  for (const ComparedRun& run : runs) ++counts[run.outcome.termination];
  const auto most = std::max_element(counts.begin(), counts.end(),
                                     [](auto& a, auto& b) { return a.second < b.second; });
  return most == counts.end() ? "" : most->first;
}

std::vector<ComparedRun> GoodRuns(const std::vector<ComparedRun>& runs) {
  std::vector<ComparedRun> good;
  std::copy_if(runs.begin(), runs.end(), std::back_inserter(good), [](const ComparedRun& run) {
    return run.converged.value_or(run.outcome.succeeded);
  });
  return good;
}

}  // namespace

ComparedRun Compare(SolveOutcome outcome, const std::optional<Rigid3d>& truth) {
  ComparedRun run;
  if (truth) {
    const PoseError error = ErrorOf(outcome.target_from_source, *truth);
    run.rotation_error_deg = error.rotation_deg;
    run.translation_error_m = error.translation_m;
    run.converged = outcome.succeeded && *run.rotation_error_deg < kMaxRotationError_deg &&
                    *run.translation_error_m < kMaxTranslationError_m;
  }
  run.outcome = std::move(outcome);
  return run;
}

ComparisonRow RowOf(const ComparedRuns& compared) {
  using Optional = std::optional<double>;
  const std::vector<ComparedRun> good = GoodRuns(compared.runs);
  // Times of failed runs are not representative.
  const std::vector<ComparedRun>& runs = good.empty() ? compared.runs : good;
  const auto median = [&](auto value_of) {
    return Median(runs, [&](auto& run) { return Optional(value_of(run.outcome)); });
  };
  ComparisonRow row;
  row.combination = compared.combination;
  row.threads = compared.threads;
  row.runs = static_cast<int>(compared.runs.size());
  row.points = static_cast<int>(median([](auto& outcome) { return outcome.points; }).value_or(0));
  row.build_ms = median([](auto& outcome) { return outcome.build_ms; });
  row.linearize_ms = median([](auto& outcome) { return outcome.linearize_ms; });
  row.solve_ms = median([](auto& outcome) { return outcome.solve_ms; });
  row.total_ms = median([](auto& outcome) { return outcome.total_ms; }).value_or(0);
  row.iterations = median([](auto& outcome) { return outcome.iterations; }).value_or(0);
  row.iteration_ms = median([](auto& outcome) { return outcome.iteration_ms; });
  row.memory_bytes = median([](auto& outcome) { return outcome.memory_bytes; });
  row.final_cost = Median(good, [](auto& run) { return Optional(run.outcome.final_cost); });
  row.rotation_error_deg = Median(good, [](auto& run) { return run.rotation_error_deg; });
  row.translation_error_m = Median(good, [](auto& run) { return run.translation_error_m; });
  const RunCounts counts = Count(compared.runs, [](auto&) { return true; });
  row.converged_ratio = counts.Ratio();
  if (counts.runs > 0) {
    std::tie(row.converged_low, row.converged_high) = WilsonInterval(counts);
  }
  row.termination = MostFrequentTermination(compared.runs);
  return row;
}

std::optional<double> RunCounts::Ratio() const {
  if (runs == 0) return std::nullopt;
  return static_cast<double>(converged) / runs;
}

RunCounts CountsOf(const ComparedRuns& runs, const PerturbationCell& cell) {
  return Count(runs.runs, [&](const ComparedRun& run) { return run.cell == cell; });
}

std::pair<double, double> WilsonInterval(const RunCounts& counts) {
  if (counts.runs == 0) return {0, 1};
  constexpr double kZ = 1.959963985;  // 97.5 % quantile of the normal distribution
  const double n = counts.runs, p = counts.converged / n, z2 = kZ * kZ;
  const double center = (p + z2 / (2 * n)) / (1 + z2 / n);
  const double half = kZ * std::sqrt(p * (1 - p) / n + z2 / (4 * n * n)) / (1 + z2 / n);
  return {std::max(0., center - half), std::min(1., center + half)};
}

}  // namespace surfit
