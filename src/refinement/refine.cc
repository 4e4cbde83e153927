#include "surfit/refinement/refine.h"

#include <cmath>
#include <utility>

#include "core/named_values.h"
#include "refinement/agreement.h"
#include "refinement/joint_covariance.h"
#include "refinement/joint_solver.h"
#include "refinement/rounds.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"

namespace surfit {
namespace {

constexpr NamedValue<RefinementTermination> kTerminations[] = {
    {"converged", RefinementTermination::kConverged},
    {"max_rounds", RefinementTermination::kMaxRounds},
    {"too_few_surfels", RefinementTermination::kTooFewSurfels},
    {"failed", RefinementTermination::kFailed}};

JointState StateOf(const std::vector<RefinementKeyframe>& keyframes,
                   const DepthCalibration& calibration) {
  JointState state;
  for (const RefinementKeyframe& keyframe : keyframes) {
    state.world_from_camera.push_back(keyframe.world_from_camera);
  }
  state.calibration = calibration;
  return state;
}

// Sets the fit and the covariances of where all is, but for the distance of the calibration.
void SetAgreement(const RefinementOptions& options,
                  const std::vector<RefinementKeyframe>& keyframes, MotionPrior* prior,
                  const JointState& state, RefinementSummary* summary) {
  const JointKernels kernels = KernelsOf(options.error_model);
  const SharedSurfels shared = MakeSharedSurfels(keyframes, state.calibration, options);
  const JointFit fit = FitOf(shared, state, kernels);
  summary->after = Agreement(fit);
  const double variance = VarianceOf(fit, shared, state, options);
  const BlockPattern pattern(shared, state.world_from_camera.size());
  ReducedSystem system = Reduce(shared, pattern, state, kernels);
  prior->SetWeight(variance);
  prior->AddTo(state, &system);
  const std::vector<bool> held = HeldCalibration(options);
  const JointCovariance covariance = CovarianceOf(system, held);
  summary->calibration_covariance =
      variance * covariance.calibration + ModelErrorOf(state.calibration, held, options);
  summary->pose_covariances.clear();
  for (const Eigen::MatrixXd& pose : covariance.poses) {
    summary->pose_covariances.push_back(variance * pose);
  }
}

RefinementFit FitOf(const RefinementOptions& options,
                    const std::vector<RefinementKeyframe>& keyframes, const JointState& state) {
  const SharedSurfels shared = MakeSharedSurfels(keyframes, state.calibration, options);
  return Agreement(FitOf(shared, state, KernelsOf(options.error_model)));
}

// Refines from the given poses; those and the calibration stay as given if it fails.
void RefineFrom(const JointState& given, const RefinementOptions& options, MotionPrior prior,
                std::vector<RefinementKeyframe>* keyframes, RefinementSummary* summary,
                const std::function<void(const RefinementRound&)>& progress) {
  TakePoses(given, keyframes);
  JointState state = given;
  summary->termination = RunRounds(options, keyframes, &prior, &state, &summary->rounds, progress);
  summary->calibration = state.calibration;
  if (summary->Succeeded()) SetAgreement(options, *keyframes, &prior, state, summary);
}

MotionPrior PriorOf(const JointState& given, const RefinementOptions& options) {
  if (options.motion_sigma_m == 0 || options.motion_sigma_rad == 0) return {};
  return {given.world_from_camera, options.motion_sigma_m, options.motion_sigma_rad};
}

bool FindsCalibration(const RefinementOptions& options) {
  return options.free_intrinsics || options.free_depth_offset || options.free_depth_field;
}

// The options with which poses alone are refined.
RefinementOptions OfPoses(RefinementOptions options) {
  options.free_intrinsics = options.free_depth_offset = options.free_depth_field = false;
  options.observation_angle_rad *= options.kept_angle_share;
  options.error_model.kernel.width *= options.kept_kernel_share;
  return options;
}

// Refines the poses with the given calibration.
void RefinePoses(const JointState& given, const RefinementOptions& options,
                 std::vector<RefinementKeyframe>* keyframes, RefinementSummary* summary,
                 const std::function<void(const RefinementRound&)>& progress) {
  const RefinementOptions of_poses = OfPoses(options);
  TakePoses(given, keyframes);
  summary->before = FitOf(of_poses, *keyframes, given);
  RefineFrom(given, of_poses, PriorOf(given, options), keyframes, summary, progress);
}

}  // namespace

std::string ToString(RefinementTermination termination) {
  return NameOf(termination, kTerminations);
}

RefinementSummary Refine(const RefinementOptions& options, const DepthCalibration& initial,
                         std::vector<RefinementKeyframe>* keyframes,
                         const std::function<void(const RefinementRound&)>& progress) {
  Validate(options);
  RefinementSummary summary;
  summary.calibration = initial;
  summary.termination = RefinementTermination::kTooFewSurfels;
  if (keyframes->size() < 2) return summary;
  const JointState given = StateOf(*keyframes, initial);
  if (!FindsCalibration(options)) {
    RefinePoses(given, options, keyframes, &summary, progress);
    return summary;
  }
  summary.before = FitOf(options, *keyframes, given);
  RefineFrom(given, options, {}, keyframes, &summary, progress);
  if (!summary.Succeeded()) return summary;
  const CalibrationChange change =
      ChangeOf(summary.calibration, initial, summary.calibration_covariance);
  summary.calibration_distance = change.squared_distance;
  summary.calibration_limit = change.Limit(options.calibration_sigmas);
  summary.calibration_kept = change.squared_distance <= summary.calibration_limit;
  if (summary.calibration_kept) {
    const Eigen::MatrixXd covariance = summary.calibration_covariance;
    RefinePoses(given, options, keyframes, &summary, progress);
    summary.calibration_covariance = covariance;
  }
  return summary;
}

}  // namespace surfit
