#include "apps/solvers/pose_problem.h"

#include <random>

#include "surfit/evaluation/error_statistics.h"

namespace surfit {
namespace {

Eigen::Vector3d RandomUnitVector(std::mt19937_64* rng) {
  std::uniform_real_distribution<double> coordinate(-1, 1);
  Eigen::Vector3d vector;
  do {
    for (int i = 0; i < 3; ++i) vector[i] = coordinate(*rng);
  } while (vector.norm() > 1 || vector.norm() < 0.1);
  return vector.normalized();
}

std::optional<double> MedianOf(const std::vector<SolveReport>& reports, double SolveReport::*time) {
  if (reports.empty()) return std::nullopt;
  std::vector<double> times;
  times.reserve(reports.size());
  for (const SolveReport& report : reports) times.push_back(report.*time);
  return Quantile(times, 0.5);
}

}  // namespace

std::vector<PerturbationCell> AllCells(int rotations, int translations) {
  std::vector<PerturbationCell> cells;
  for (int i = 0; i < rotations; ++i) {
    for (int j = 0; j < translations; ++j) cells.push_back({i, j});
  }
  return cells;
}

Rigid3d Perturbed(const Rigid3d& target_from_source, double rotation_rad, double translation_m,
                  std::uint64_t seed) {
  // Avoids the rounding errors of LeftIncrement().
  if (rotation_rad == 0 && translation_m == 0) return target_from_source;
  std::mt19937_64 rng(seed);
  Eigen::Matrix<double, 6, 1> increment;
  increment.head<3>() = rotation_rad * RandomUnitVector(&rng);
  increment.tail<3>() = translation_m * RandomUnitVector(&rng);
  return LeftIncrement<double>(increment, target_from_source);
}

void SetTimes(const std::vector<SolveReport>& reports, SolveOutcome* outcome) {
  outcome->build_ms = MedianOf(reports, &SolveReport::build_ms);
  if (outcome->build_ms == 0) outcome->build_ms.reset();  // 0: the solver builds no Ceres problem
  outcome->linearize_ms = MedianOf(reports, &SolveReport::linearize_ms);
  outcome->solve_ms = MedianOf(reports, &SolveReport::solve_ms);
}

SolveOutcome OutcomeOf(const IcpResult& result, int points, double total_ms) {
  SolveOutcome outcome;
  outcome.target_from_source = result.target_from_source;
  outcome.termination = ToString(result.termination);
  outcome.succeeded = result.Succeeded();
  outcome.points = points;
  outcome.iterations = result.step_count;
  outcome.total_ms = total_ms;
  std::vector<SolveReport> reports;
  for (const IcpIteration& iteration : result.iterations) {
    outcome.losses.push_back(iteration.average_loss);
    if (iteration.level == 0 && !iteration.report.costs.empty()) {
      reports.push_back(iteration.report);
    }
  }
  SetTimes(reports, &outcome);
  // If the last step increased the RMSE, ICP returns the pose before this step.
  const std::size_t back = result.termination == Termination::kRmseIncreased ? 2 : 1;
  if (result.iterations.size() >= back) {
    outcome.final_cost = (result.iterations.end() - back)->cost;
  }
  return outcome;
}

}  // namespace surfit
