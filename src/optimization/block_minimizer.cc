#include "optimization/block_minimizer.h"

#include <chrono>
#include <cmath>
#include <utility>

namespace surfit {
namespace {

// As in Ceres.
constexpr double kMinGain = 1e-3;  // of the cost decrease that was promised
constexpr double kMinRadius = 1e-32;

double WeightedCost(const PoseGraphProblem& problem) {
  const std::vector<double> errors = problem.SquaredErrors();
  double sum = 0;
  for (std::size_t i = 0; i < errors.size(); ++i) sum += problem.weights[i] * errors[i];
  return sum / 2;
}

void Move(const UnknownPoses& unknowns, const Eigen::VectorXd& increments,
          std::vector<Rigid3d>* poses) {
  for (std::size_t i = 0; i < poses->size(); ++i) {
    if (unknowns.numbers[i] == kHeld) continue;
    const Eigen::Matrix<double, 6, 1> increment = increments.segment<6>(6 * unknowns.numbers[i]);
    Rigid3d& pose = (*poses)[i];
    pose.rotation = (QuaternionExp<double>(increment.head<3>()) * pose.rotation).normalized();
    pose.translation += increment.tail<3>();
  }
}

class Clock {
 public:
  double LapMs() {
    const auto now = std::chrono::steady_clock::now();
    return std::chrono::duration<double, std::milli>(now - std::exchange(last_, now)).count();
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

}  // namespace

BlockMinimizer::Attempt BlockMinimizer::Try(double cost, double min_relative_cost_change,
                                            TrustRegion* region) {
  Attempt attempt;
  attempt.cost = cost;
  const std::optional<PoseGraphStep> step = equations_.Solve(region->radius());
  if (!step) {
    region->Refuse();
    return attempt;
  }
  std::vector<Rigid3d> former = problem_->world_from_pose;
  Move(equations_.unknowns(), step->increments, &problem_->world_from_pose);
  const double moved_cost = WeightedCost(*problem_), decrease = cost - moved_cost;
  const double gain = decrease / step->cost_decrease;
  attempt.step_norm = step->increments.norm();
  attempt.accepted = gain > kMinGain;
  attempt.converged = std::abs(decrease) <= min_relative_cost_change * cost;
  if (attempt.accepted) {
    attempt.cost = moved_cost;
    region->Accept(gain);
  } else {
    problem_->world_from_pose = std::move(former);
    region->Refuse();
  }
  return attempt;
}

PoseGraphTermination BlockMinimizer::Minimize(const MinimizerOptions& options,
                                              PoseGraphSummary* summary) {
  Clock clock;
  const auto record = [&](const Attempt& a) {
    summary->iterations.push_back(
        {summary->round_count, a.cost, a.step_norm, a.accepted, clock.LapMs()});
  };
  Attempt last;
  last.cost = WeightedCost(*problem_);
  last.accepted = true;
  if (!std::isfinite(last.cost)) return PoseGraphTermination::kFailed;
  record(last);
  TrustRegion region(options.initial_radius);
  for (int i = 0; i < options.max_iterations && region.radius() >= kMinRadius; ++i) {
    if (last.accepted) equations_.Linearize(*problem_);
    last = Try(last.cost, options.min_relative_cost_change, &region);
    record(last);
    if (last.converged) return PoseGraphTermination::kConverged;
  }
  return region.radius() < kMinRadius ? PoseGraphTermination::kConverged
                                      : PoseGraphTermination::kMaxIterations;
}

}  // namespace surfit
