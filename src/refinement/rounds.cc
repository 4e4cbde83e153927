#include "refinement/rounds.h"

#include <algorithm>
#include <optional>

#include "refinement/agreement.h"
#include "refinement/joint_solver.h"
#include "surfit/core/trace.h"

namespace surfit {
namespace {

constexpr std::size_t kLeastSurfels = 100;

// One round: how it failed, if it did.
std::optional<RefinementTermination> RunRound(const RefinementOptions& options,
                                              const JointKernels& kernels,
                                              const std::vector<RefinementKeyframe>& keyframes,
                                              MotionPrior* prior, JointState* state,
                                              RefinementRound* round) {
  const TraceSlice slice("refine_round");
  const SharedSurfels shared = MakeSharedSurfels(keyframes, state->calibration, options);
  round->surfels = shared.surfels.size();
  round->observations = shared.observations.size();
  round->texture_observations = shared.textures.size();
  if (shared.surfels.size() < kLeastSurfels) return RefinementTermination::kTooFewSurfels;
  const JointFit before = FitOf(shared, *state, kernels);
  round->before = Agreement(before);
  prior->SetWeight(VarianceOf(before, shared, *state, options));
  round->iterations = MinimizeJointly(shared, *prior, kernels, options, state);
  if (round->iterations == kNoSolution) return RefinementTermination::kFailed;
  round->after = Agreement(FitOf(shared, *state, kernels));
  round->calibration = state->calibration;
  return std::nullopt;
}

}  // namespace

void TakePoses(const JointState& state, std::vector<RefinementKeyframe>* keyframes) {
  for (std::size_t k = 0; k < keyframes->size(); ++k) {
    (*keyframes)[k].world_from_camera = state.world_from_camera[k];
  }
}

RefinementTermination RunRounds(const RefinementOptions& options,
                                std::vector<RefinementKeyframe>* keyframes, MotionPrior* prior,
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

}  // namespace surfit
