#include "surfit/optimization/refine.h"

#include <algorithm>

#include "core/named_values.h"
#include "core/trace.h"
#include "optimization/refinement/held_out.h"
#include "optimization/refinement/joint_solver.h"
#include "optimization/refinement/reduced_factor.h"
#include "surfit/core/options.h"

namespace surfit {
namespace {

constexpr std::size_t kMinSurfels = 100;

// Returns std::nullopt on success.
std::optional<RefinementTermination> RunRound(const RefinementOptions& options,
                                              const JointKernels& kernels,
                                              const std::vector<RefinementKeyframe>& keyframes,
                                              JointPrior* prior, JointState* state,
                                              RefinementRound* round) {
  const TraceSlice slice("refine_round");
  const SharedSurfels shared = MakeSharedSurfels(keyframes, state->calibration, options);
  round->surfels = shared.surfels.size();
  round->observations = shared.observations.size();
  round->texture_observations = shared.textures.size();
  if (shared.surfels.size() < kMinSurfels) return RefinementTermination::kTooFewSurfels;
  const JointFit before = FitOf(shared, *state, kernels);
  round->before = Agreement(before);
  prior->SetWeight(VarianceOf(before, shared, *state, options));
  round->iterations = MinimizeJointly({shared, *prior, kernels}, options, state).iterations;
  if (round->iterations == kNoSolution) return RefinementTermination::kFailed;
  round->after = Agreement(FitOf(shared, *state, kernels));
  round->calibration = state->calibration;
  return std::nullopt;
}

constexpr NamedValue<RefinementTermination> kRefinementEnds[] = {
    {"converged", RefinementTermination::kConverged},
    {"max_rounds", RefinementTermination::kMaxRounds},
    {"too_few_surfels", RefinementTermination::kTooFewSurfels},
    {"failed", RefinementTermination::kFailed}};

void TakePoses(const JointState& state, std::vector<RefinementKeyframe>* keyframes) {
  for (std::size_t k = 0; k < keyframes->size(); ++k) {
    (*keyframes)[k].world_from_camera = state.world_from_camera[k];
  }
}

// A failure restores state and keyframes.
RefinementTermination RunRounds(const RefinementOptions& options,
                                std::vector<RefinementKeyframe>* keyframes, JointPrior* prior,
                                JointState* state, std::vector<RefinementRound>* rounds,
                                const std::function<void(const RefinementRound&)>& progress) {
  const JointState given = *state;
  double growth = options.kernel_growth;
  for (int i = 0; i < options.max_rounds; ++i) {
    RefinementRound round;
    const JointKernels kernels = KernelsOf(options.error_model).Widened(growth);
    const auto failure = RunRound(options, kernels, *keyframes, prior, state, &round);
    if (failure) {
      *state = given;
      TakePoses(given, keyframes);
      return *failure;
    }
    TakePoses(*state, keyframes);
    rounds->push_back(round);
    progress(round);
    const double change = 1 - round.after.cost / round.before.cost;
    if (growth == 1 && change < options.min_relative_cost_change) {
      return RefinementTermination::kConverged;
    }
    growth = std::max(1., growth / 2);
  }
  return RefinementTermination::kMaxRounds;
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

bool FindsCalibration(const RefinementOptions& options) {
  return options.estimate_intrinsics || options.estimate_depth_offset ||
         options.estimate_depth_field || options.estimate_readout;
}

void SetFinalFit(const RefinementOptions& options, const std::vector<RefinementKeyframe>& keyframes,
                 const DepthCalibration& given, JointPrior* prior, const JointState& state,
                 RefinementSummary* summary) {
  const JointKernels kernels = KernelsOf(options.error_model);
  const SharedSurfels shared = MakeSharedSurfels(keyframes, state.calibration, options);
  const JointFit fit = FitOf(shared, state, kernels);
  summary->after = Agreement(fit);
  const double variance = VarianceOf(fit, shared, state, options);
  const BlockPattern pattern(shared, state.world_from_camera.size());
  ReducedSystem system = Reduce(shared, pattern, state, kernels);
  prior->SetWeight(variance);
  prior->AddTo(state, &system);
  const std::vector<bool> held = FixedCalibration(options);
  const JointCovariance covariance = CovarianceOf(system, held);
  summary->calibration_covariance =
      variance * covariance.calibration + ModelErrorOf(state.calibration, held, options);
  summary->pose_covariances.clear();
  for (const Eigen::MatrixXd& pose : covariance.poses) {
    summary->pose_covariances.emplace_back(variance * pose);
  }
  if (FindsCalibration(options)) {
    const HalfGains gains = GainsOf(shared, state, given, *prior, options);
    summary->half_gains = gains.own;
    summary->held_out_gains = gains.held_out;
  }
}

RefinementFit FitOf(const RefinementOptions& options,
                    const std::vector<RefinementKeyframe>& keyframes, const JointState& state) {
  const SharedSurfels shared = MakeSharedSurfels(keyframes, state.calibration, options);
  return Agreement(FitOf(shared, state, KernelsOf(options.error_model)));
}

// A failure restores poses and calibration.
void RefineFrom(const JointState& start, const DepthCalibration& given,
                const RefinementOptions& options, JointPrior prior,
                std::vector<RefinementKeyframe>* keyframes, RefinementSummary* summary,
                const std::function<void(const RefinementRound&)>& progress) {
  TakePoses(start, keyframes);
  summary->calibration_covariance.resize(0, 0);
  summary->pose_covariances.clear();
  summary->after = {};
  JointState state = start;
  summary->termination = RunRounds(options, keyframes, &prior, &state, &summary->rounds, progress);
  // Noise can make the estimate negative.
  state.calibration.readout_s = std::max(0., state.calibration.readout_s);
  summary->calibration = state.calibration;
  if (summary->Succeeded()) {
    SetFinalFit(options, *keyframes, given, &prior, state, summary);
  }
}

JointPrior PriorOf(const JointState& given, const RefinementOptions& options) {
  if (options.motion_sigma_m == 0 || options.motion_sigma_rad == 0) return {};
  return {given.world_from_camera, options.motion_sigma_m, options.motion_sigma_rad};
}

// Fixes the readout if no keyframe has motion.
RefinementOptions WithObservableParameters(RefinementOptions options,
                                           const std::vector<RefinementKeyframe>& keyframes) {
  options.estimate_readout &=
      std::any_of(keyframes.begin(), keyframes.end(),
                  [](const RefinementKeyframe& k) { return !k.images.readout.motion.IsZero(); });
  return options;
}

RefinementOptions PosesOnly(RefinementOptions options) {
  options.estimate_intrinsics = options.estimate_depth_offset = options.estimate_depth_field =
      false;
  options.estimate_readout = false;
  options.observation_angle_rad *= options.kept_angle_ratio;
  options.error_model.kernel.width *= options.kept_kernel_ratio;
  return options;
}

void RefinePoses(const JointState& given, const RefinementOptions& options,
                 std::vector<RefinementKeyframe>* keyframes, RefinementSummary* summary,
                 const std::function<void(const RefinementRound&)>& progress) {
  const RefinementOptions of_poses = PosesOnly(options);
  TakePoses(given, keyframes);
  summary->before = FitOf(of_poses, *keyframes, given);
  RefineFrom(given, given.calibration, of_poses, PriorOf(given, options), keyframes, summary,
             progress);
}

}  // namespace

bool RefinementSummary::AreGainsAboveLimit() const {
  return std::min(half_gains[0], half_gains[1]) > gain_limit &&
         held_out_gains[0] + held_out_gains[1] > gain_limit;
}

std::string ToString(RefinementTermination termination) {
  return NameOf(termination, kRefinementEnds);
}

RefinementSummary Refine(const RefinementOptions& all_options, const DepthCalibration& given,
                         const DepthCalibration& start, std::vector<RefinementKeyframe>* keyframes,
                         const std::function<void(const RefinementRound&)>& progress) {
  Validate(all_options);
  const RefinementOptions options = WithObservableParameters(all_options, *keyframes);
  RefinementSummary summary;
  summary.calibration = start;
  summary.termination = RefinementTermination::kTooFewSurfels;
  if (keyframes->size() < 2) return summary;
  const JointState from = StateOf(*keyframes, start), as_given = StateOf(*keyframes, given);
  if (!FindsCalibration(options)) {
    RefinePoses(as_given, options, keyframes, &summary, progress);
    return summary;
  }
  summary.before = FitOf(options, *keyframes, from);
  RefineFrom(from, given, options, {given, options.prior.Over({})}, keyframes, &summary, progress);
  if (!summary.Succeeded()) return summary;
  const CalibrationChange change =
      ChangeOf(summary.calibration, given, summary.calibration_covariance);
  summary.calibration_distance = change.squared_distance;
  summary.calibration_limit = change.Limit(options.calibration_sigmas);
  // A calibration that is in use needs less evidence: the return to the input is a step, too.
  const bool is_new = AreSame(start, given);
  summary.gain_limit = is_new ? change.Limit(options.calibration_sigmas) - change.free : 0;
  summary.calibration_kept =
      change.squared_distance <= summary.calibration_limit || !summary.AreGainsAboveLimit();
  if (summary.calibration_kept) {
    const Eigen::MatrixXd covariance = summary.calibration_covariance;
    RefinePoses(as_given, options, keyframes, &summary, progress);
    if (summary.Succeeded()) summary.calibration_covariance = covariance;
  }
  return summary;
}

RefinementSummary Refine(const RefinementOptions& options, const DepthCalibration& given,
                         std::vector<RefinementKeyframe>* keyframes,
                         const std::function<void(const RefinementRound&)>& progress) {
  return Refine(options, given, given, keyframes, progress);
}

}  // namespace surfit
