#include "registration/icp/icp_level.h"

#include <algorithm>
#include <cmath>

namespace surfit {
namespace {

constexpr double kLeastPairs = 6;  // number of unknowns of a pose

struct PoseState {
  Rigid3d pose;
  StepResult step;

  // RMS of all residuals, used by the termination criteria.
  double JointRmse() const {
    const double weight_sum = step.system.weight_sum;
    const double of_prior = weight_sum > 0 ? 2 * step.prior_cost / weight_sum : 0;
    return std::sqrt(step.system.JointLoss() + of_prior);
  }
};

class LevelRun {
 public:
  LevelRun(const IcpLevel& level, const IcpOptions& options, IcpResult* result)
      : level_(level),
        options_(options),
        result_(*result),
        source_count_(level.association.source_count()) {}

  void Run() {
    Iterate();
    if (level_.level > 0 || level_.has_prior || !result_.Succeeded()) return;
    const Observability held = Observe(result_.system, options_.observability);
    if (!held.Degenerate()) return;
    UndoDegenerateMotion(held);
    checks_normal_noise_ = true;
    Iterate();
  }

 private:
  void Iterate() {
    PoseState best;
    Rigid3d pose = result_.target_from_source;
    result_.termination = Termination::kMaxIterations;
    for (int i = 0;; ++i) {
      const bool is_last =
          result_.termination == Termination::kConverged || i == options_.max_iterations;
      PoseState state = StateAt(pose, is_last);
      Record(state);
      if (HasTooFewPairs(state)) return Finish(state, Termination::kTooFewInliers);
      if (i > 0 && RmseIncreased(best, state)) return Finish(best, Termination::kRmseIncreased);
      if (is_last) return Finish(state, result_.termination);
      if (Converged(state, i > 0 ? best.JointRmse() : 0))
        result_.termination = Termination::kConverged;
      pose = LeftIncrement(state.step.increment, pose);
      ++result_.step_count;
      best = std::move(state);
    }
  }

  PoseState StateAt(const Rigid3d& pose, bool is_last) const {
    PoseState state{pose, is_last ? level_.solver.Describe(level_.association, pose)
                                  : level_.solver.Step(level_.association, pose)};
    if (checks_normal_noise_) {
      state.step.observability = Observe(state.step.system, options_.observability);
      state.step.increment = state.step.observability.Held(state.step.increment);
    }
    return state;
  }

  void UndoDegenerateMotion(const Observability& held) {
    const Vector6d motion = FirstOrderIncrement(level_.start, result_.target_from_source);
    result_.target_from_source = LeftIncrement(held.Held(motion), level_.start);
  }

  bool HasTooFewPairs(const PoseState& state) const {
    const double least_pairs = std::ldexp(options_.min_inliers, -level_.level);
    const double least_share = options_.min_inlier_ratio * source_count_;
    return state.step.system.pair_count < std::max({least_pairs, least_share, kLeastPairs});
  }

  // Ignores increases within the convergence tolerance, and increases with more inliers, because
  // the pose may still improve.
  bool RmseIncreased(const PoseState& best, const PoseState& state) const {
    return options_.stop_at_rmse_increase &&
           state.JointRmse() > (1 + options_.min_relative_rmse_change) * best.JointRmse() &&
           state.step.system.inlier_count <= best.step.system.inlier_count;
  }

  bool Converged(const PoseState& state, double last_rmse) const {
    const double turn_rad = state.step.increment.head<3>().norm();
    const double shift_m = state.step.increment.tail<3>().norm();
    if (turn_rad < options_.min_increment && shift_m < options_.min_increment) return true;
    const double step_px = level_.focal_px * (turn_rad + shift_m / state.step.system.RmsDistance());
    if (level_.level > 0 && step_px < options_.min_coarse_step_px) return true;
    return last_rmse > 0 &&
           std::abs(state.JointRmse() - last_rmse) < options_.min_relative_rmse_change * last_rmse;
  }

  void Record(const PoseState& state) {
    const NormalSystem& system = state.step.system;
    result_.iterations.push_back(
        {level_.level, system.AverageLoss(), system.cost, system.inlier_count, state.step.report});
  }

  void Finish(const PoseState& state, Termination termination) {
    const NormalSystem& system = state.step.system;
    const Observability& observability = state.step.observability;
    result_.termination = termination;
    result_.target_from_source = state.pose;
    result_.inlier_count = system.inlier_count;
    result_.inlier_ratio =
        source_count_ > 0 ? static_cast<double>(system.inlier_count) / source_count_ : 0;
    result_.rmse_m = std::sqrt(system.AverageLoss());
    result_.intensity_count = system.photometric.row_count;
    result_.information = system.hessian;
    result_.system = system;
    result_.trusted_information =
        ConservativeInformation(system, options_.error_model.TrustedPhotometricRatio());
    result_.eigenvalues = observability.eigenvalues;
    result_.degenerate_directions = observability.DegenerateDirections();
    result_.covariance.reset();
    if (!observability.Degenerate()) result_.covariance = CovarianceOf(system);
    if (observability.Degenerate() && result_.Succeeded()) {
      result_.termination = Termination::kSingularSystem;
    }
  }

  const IcpLevel& level_;
  const IcpOptions& options_;
  IcpResult& result_;
  int source_count_;
  bool checks_normal_noise_ = false;  // true: Iterate() applies options.observability
};

}  // namespace

PoseSolverOptions SolverOptions(const IcpOptions& options, const ErrorModel& error_model) {
  return {
      options.solver,
      options.linear_solver,
      ResidualTypeFromName(options.residual),
      error_model,
      {std::min(options.observability.min_eigenvalue, ObservabilityOptions().min_eigenvalue), 0},
      options.min_relative_rmse_change};
}

void RunLevel(const IcpLevel& level, const IcpOptions& options, IcpResult* result) {
  LevelRun(level, options, result).Run();
}

}  // namespace surfit
