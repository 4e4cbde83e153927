#include "surfit/refinement/refine.h"

#include <algorithm>
#include <cmath>

#include "core/named_values.h"
#include "cost_functions/plane_inverse_depth.h"
#include "refinement/calibration_covariance.h"
#include "refinement/joint_solver.h"
#include "surfit/core/error.h"
#include "surfit/core/trace.h"

namespace surfit {
namespace {

constexpr std::size_t kLeastSurfels = 100;

constexpr NamedValue<RefinementTermination> kTerminations[] = {
    {"converged", RefinementTermination::kConverged},
    {"max_rounds", RefinementTermination::kMaxRounds},
    {"too_few_surfels", RefinementTermination::kTooFewSurfels},
    {"failed", RefinementTermination::kFailed}};

void Require(bool holds, const char* field, double value, const char* constraint) {
  if (!holds) throw InputError(Concat(field, " is ", value, ", must be ", constraint));
}

RefinementFit Agreement(const JointFit& fit) {
  if (!(fit.weight > 0)) return {};
  return {fit.rho / 2, std::sqrt(fit.squared_sigmas / fit.weight),
          std::sqrt(fit.squared_metres / fit.weight)};
}

JointState StateOf(const std::vector<RefinementKeyframe>& keyframes,
                   const DepthCalibration& calibration) {
  JointState state;
  for (const RefinementKeyframe& keyframe : keyframes) {
    state.world_from_camera.push_back(keyframe.world_from_camera);
  }
  state.calibration = calibration;
  return state;
}

void TakePoses(const JointState& state, std::vector<RefinementKeyframe>* keyframes) {
  for (std::size_t k = 0; k < keyframes->size(); ++k) {
    (*keyframes)[k].world_from_camera = state.world_from_camera[k];
  }
}

RobustKernel Widened(RobustKernel kernel, double growth) {
  kernel.width *= growth;
  return kernel;
}

// The factor of an observation's variance that the residuals show: their weighted mean square, for
// as many as they are more than what they determine.
double VarianceFactor(const JointFit& fit, const SharedSurfels& shared, std::size_t poses) {
  const double all = static_cast<double>(shared.observations.size());
  const double found = static_cast<double>(shared.surfels.size() + kPoseTangentSize * poses);
  return all > found && fit.weight > 0 ? fit.squared_sigmas / fit.weight * all / (all - found) : 0;
}

// One round: false if it failed, with the termination that says how.
bool RunRound(const RefinementOptions& options, const RobustKernel& kernel,
              const std::vector<RefinementKeyframe>& keyframes, JointState* state,
              RefinementRound* round, RefinementTermination* termination) {
  const TraceSlice slice("refine_round");
  const SharedSurfels shared = MakeSharedSurfels(keyframes, state->calibration, options);
  round->surfels = shared.surfels.size();
  round->observations = shared.observations.size();
  if (shared.surfels.size() < kLeastSurfels) {
    *termination = RefinementTermination::kTooFewSurfels;
    return false;
  }
  round->before = Agreement(FitOf(shared, *state, kernel));
  round->iterations = MinimizeJointly(shared, kernel, options, state);
  if (round->iterations == kNoSolution) {
    *termination = RefinementTermination::kFailed;
    return false;
  }
  round->after = Agreement(FitOf(shared, *state, kernel));
  round->calibration = state->calibration;
  return true;
}

void SetCovariance(const RefinementOptions& options,
                   const std::vector<RefinementKeyframe>& keyframes, const JointState& state,
                   RefinementSummary* summary) {
  const RobustKernel& kernel = options.error_model.kernel;
  const SharedSurfels shared = MakeSharedSurfels(keyframes, state.calibration, options);
  const JointFit fit = FitOf(shared, state, kernel);
  const double cells_per_window =
      static_cast<double>(options.correlation_px) / CellSize(state.calibration, options);
  summary->calibration_covariance =
      VarianceFactor(fit, shared, keyframes.size()) * std::max(1., std::pow(cells_per_window, 2)) *
      CalibrationCovariance(Reduce(shared, state, kernel), HeldCalibration(options));
}

}  // namespace

std::string ToString(RefinementTermination termination) {
  return NameOf(termination, kTerminations);
}

void RefinementOptions::Validate() const {
  Require(cells_across >= 1, "cells_across", cells_across, "at least 1");
  Require(min_observations >= 2, "min_observations", min_observations, "at least 2");
  Require(max_distance_m > 0, "max_distance_m", max_distance_m, "positive");
  Require(max_normal_angle_rad > 0 && max_normal_angle_rad < M_PI / 2, "max_normal_angle_rad",
          max_normal_angle_rad, "positive and below pi/2");
  Require(max_slant_rad > 0 && max_slant_rad < M_PI / 2, "max_slant_rad", max_slant_rad,
          "positive and below pi/2");
  error_model.Validate();
  Require(max_rounds >= 1 && max_rounds <= 1000, "max_rounds", max_rounds, "from 1 to 1000");
  Require(max_iterations >= 1 && max_iterations <= 1000, "max_iterations", max_iterations,
          "from 1 to 1000");
  Require(min_relative_cost_change >= 0, "min_relative_cost_change", min_relative_cost_change,
          "zero or positive");
  Require(correlation_px >= 1, "correlation_px", correlation_px, "at least 1");
  Require(kernel_growth >= 1, "kernel_growth", kernel_growth, "at least 1");
}

RefinementSummary Refine(const RefinementOptions& options, const DepthCalibration& initial,
                         std::vector<RefinementKeyframe>* keyframes,
                         const std::function<void(const RefinementRound&)>& progress) {
  options.Validate();
  RefinementSummary summary;
  summary.calibration = initial;
  summary.termination = RefinementTermination::kTooFewSurfels;
  if (keyframes->size() < 2) return summary;
  const JointState given = StateOf(*keyframes, initial);
  JointState state = given;
  double growth = options.kernel_growth;
  summary.termination = RefinementTermination::kMaxRounds;
  for (int i = 0; i < options.max_rounds; ++i) {
    RefinementRound round;
    const RobustKernel kernel = Widened(options.error_model.kernel, growth);
    if (!RunRound(options, kernel, *keyframes, &state, &round, &summary.termination)) {
      TakePoses(given, keyframes);
      return summary;
    }
    TakePoses(state, keyframes);
    summary.rounds.push_back(round);
    progress(round);
    const double change = 1 - round.after.cost / round.before.cost;
    if (growth == 1 && change < options.min_relative_cost_change) {
      summary.termination = RefinementTermination::kConverged;
      break;
    }
    growth = std::max(1., growth / 2);
  }
  summary.calibration = state.calibration;
  SetCovariance(options, *keyframes, state, &summary);
  return summary;
}

}  // namespace surfit
