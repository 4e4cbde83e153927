#include "tracking/frame_registration.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include "registration/solvers/decompositions.h"
#include "tracking/pose_validation.h"
#include "tracking/view_comparison.h"

namespace surfit {
namespace {

// Maximum deviation of a weakly constrained frame from the motion prior, in standard deviations.
// Repetitive texture pulls such registrations to a wrong minimum. At `acceleration_m_per_s2` =
// 2, the bound is 1 g.
constexpr double kMaxSigmas = 5;

// Maximum eigenvalue of weak directions, as a factor of TrackingOptions::min_turn_eigenvalue. It is
// above 1, because a slide has components along the next stronger directions.
constexpr double kWeakDirections = 2.5;

// Directions with smaller eigenvalues do not correct an inertial prediction. The value is between
// those of walls (3e-4) and of rooms (5e-3), see ObservabilityOptions.
constexpr double kSpuriousEigenvalue = 1e-3;

// Depth leaves directions with a smaller ratio of information to spurious information open. Along
// walls and corridors, the ratio is at most 1. In recordings of rooms, it is at least 1.6.
constexpr double kMinInformationRatio = 1.25;

// Bounds of weakly constrained frames in a hurry: a factor of
// TrackingOptions::min_turn_eigenvalue, and a ratio of information to spurious information. In
// views of the end of a corridor, the ratio is at most 1.7.
constexpr double kHurriedEigenvalue = 0.5, kHurriedInformationRatio = 1.75;

std::vector<Vector6d> DegenerateDirections(const IcpResult& icp, double min_information_ratio) {
  if (icp.iterations.empty()) return {};
  ObservabilityOptions options;
  options.min_information_ratio = min_information_ratio;
  return Observe(icp.system, options).DegenerateDirections();
}

// Moves the pose of `by_shape` towards `with_intensities`, along weak directions only. Colour with
// an inaccurate timestamp or inaccurate extrinsics thus does not change the other directions.
Rigid3d MovedAlongWeakDirections(const IcpResult& by_shape, const Rigid3d& with_intensities,
                                 double max_eigenvalue) {
  ObservabilityOptions weak;
  weak.min_eigenvalue = max_eigenvalue;
  const Vector6d motion = FirstOrderIncrement(by_shape.target_from_source, with_intensities);
  const Vector6d along_weak = motion - Observe(by_shape.system, weak).Held(motion);
  return LeftIncrement<double>(along_weak, by_shape.target_from_source);
}

// Information of a registration without directions that depth may not constrain. There, noise and
// errors of the map determine the pose, and a slide continues for many frames.
Matrix6d InformationWithoutSlides(const IcpResult& icp) {
  ObservabilityOptions options;
  options.min_eigenvalue = kSpuriousEigenvalue;
  const Observability observability = Observe(icp.system, options);
  Matrix6d held;
  for (int k = 0; k < 6; ++k) held.col(k) = observability.Held(Vector6d::Unit(k));
  return held.transpose() * icp.trusted_information * held;
}

// Information of a pose with additional noise in the camera frame. Directions without information
// get a standard deviation of 1 rad or 1 m.
Matrix6d WithNoise(const Matrix6d& information, const Rigid3d& reference_from_camera,
                   const Matrix6d& noise) {
  if (noise.isZero(0)) return information;
  const Matrix6d covariance = SymmetricInverse(information + Matrix6d::Identity());
  return SymmetricInverse(covariance + In(reference_from_camera, {Rigid3d(), noise}).covariance);
}

std::ptrdiff_t CountCells(const CellMask& moving) {
  return std::count_if(moving.begin(), moving.end(), [](auto cell) { return cell != kNotMoving; });
}

}  // namespace

int CountNormals(const PreprocessedFrame& frame, const CellMask& moving) {
  const Image<float> normal_z = Without(frame.surface().normal.z, moving);
  return static_cast<int>(
      std::count_if(normal_z.begin(), normal_z.end(), [](float z) { return z < 0; }));
}

bool HasEnoughDepth(const PreprocessedFrame& frame, const IcpOptions& icp_options) {
  return CountNormals(frame) >= icp_options.min_inliers;
}

Tracked FrameRegistration::Register(const PreprocessedFrame& frame, const ReferenceView& reference,
                                    const Rigid3d& world_from_initial,
                                    const IcpOptions& icp_options,
                                    const std::optional<MotionUncertainty>& motion) const {
  const Rigid3d initial = reference.world_from_view.Inverse() * world_from_initial;
  Target target = {reference, icp_options, std::nullopt, {}};
  if (motion) {
    target.prior = In(initial, {Rigid3d(), motion->covariance});
    target.motion = *motion;
  }
  Tracked tracked = Validate(frame, target, MostLikelyPose(frame.view.pyramid, target, initial));
  if (tracked.has_pose()) return tracked;
  // A moving object in a large part of the view can pull the registration to a wrong minimum.
  Estimate unmoved;
  unmoved.icp.target_from_source = unmoved.registered = initial;
  const Tracked hidden = Validate(frame, target, unmoved);
  if (!hidden.has_pose()) return tracked;
  const Tracked again = Validate(
      frame, target,
      {hidden.icp, icp_options, reference.world_from_view.Inverse() * hidden.world_from_registered,
       hidden.quality.is_weakly_constrained, hidden.icp.degenerate_directions, std::nullopt});
  return again.has_pose() ? again : tracked;
}

FrameRegistration::Estimate FrameRegistration::MostLikelyPose(
    const FramePyramid& frame, const Target& target, const Rigid3d& reference_from_initial) const {
  Estimate estimate = FromData(frame, target, reference_from_initial);
  estimate.registered = estimate.icp.target_from_source;
  const bool is_registered =
      estimate.icp.Succeeded() || estimate.icp.termination == Termination::kSingularSystem;
  // The solver svd has no normal equations, so the prior is its initial pose only.
  if (!target.prior || !is_registered || target.icp.solver == "svd") return estimate;
  const Vector6d weights = target.motion.registration_scale.cwiseInverse();
  const Matrix6d trusted = target.motion.IsInertial() ? InformationWithoutSlides(estimate.icp)
                                                      : estimate.icp.trusted_information;
  const Matrix6d scaled = weights.asDiagonal() * trusted * weights.asDiagonal();
  const Matrix6d information =
      WithNoise(scaled, estimate.registered, target.motion.registration_noise);
  estimate.squared_difference = SquaredDifference(*target.prior, estimate.registered, information);
  const double max_sigmas = target.motion.max_sigmas.value_or(
      estimate.is_weakly_constrained ? kMaxSigmas : std::numeric_limits<double>::infinity());
  const ExpectedPose likely =
      MostLikely(*target.prior, estimate.registered, information, max_sigmas);
  estimate.covariance = likely.covariance;
  if (target.motion.holds_weak_frames_only && !estimate.is_weakly_constrained) return estimate;
  estimate.icp.target_from_source = likely.target_from_source;
  // Correspondences follow the pose, so further steps along weakly constrained directions follow
  // noise.
  if (estimate.is_weakly_constrained) return estimate;
  const std::optional<PriorTerm> prior = InUnitsOf(estimate.icp.information, *target.prior,
                                                   estimate.registered, information, max_sigmas);
  if (prior) MinimizeWithPrior(frame, target, *prior, &estimate);
  return estimate;
}

// The linearised pose may differ from the minimum over data and prior, because correspondences
// and kernel weights depend on the pose. Information and statistics are of the registration without
// the prior.
void FrameRegistration::MinimizeWithPrior(const FramePyramid& frame, const Target& target,
                                          const PriorTerm& prior, Estimate* estimate) const {
  IcpResult& icp = estimate->icp;
  const IcpResult with_prior = RegisterWithPrior(frame, target.reference.view.pyramid,
                                                 icp.target_from_source, prior, estimate->options);
  icp.iterations.insert(icp.iterations.end(), with_prior.iterations.begin(),
                        with_prior.iterations.end());
  icp.step_count += with_prior.step_count;
  if (with_prior.termination != Termination::kTooFewInliers) {
    icp.target_from_source = with_prior.target_from_source;
  }
}

bool FrameRegistration::IsWeaklyConstrained(const IcpResult& icp) const {
  if (icp.iterations.empty()) return false;
  const double bound = options_.min_turn_eigenvalue;
  if (!is_hurried_) return icp.eigenvalues[0] < bound;
  return icp.eigenvalues[0] < kHurriedEigenvalue * bound ||
         !DegenerateDirections(icp, kHurriedInformationRatio).empty();
}

FrameRegistration::Estimate FrameRegistration::FromData(
    const FramePyramid& frame, const Target& target, const Rigid3d& reference_from_initial) const {
  const FramePyramid& model = target.reference.view.pyramid;
  Estimate estimate;
  estimate.options = target.icp;
  estimate.icp = surfit::Register(frame, model, reference_from_initial, target.icp);
  estimate.degenerate_directions = DegenerateDirections(estimate.icp, kMinInformationRatio);
  estimate.is_weakly_constrained =
      !estimate.degenerate_directions.empty() || IsWeaklyConstrained(estimate.icp);
  const bool can_help = options_.weakly_constrained_photometric_weight > 0 &&
                        !target.icp.error_model.UsesIntensities() &&
                        !frame.levels.front().intensity.empty() &&
                        !model.levels.front().intensity.empty();
  if (!estimate.is_weakly_constrained || !can_help) return estimate;
  IcpOptions with_intensities = target.icp;
  with_intensities.error_model.photometric_weight = options_.weakly_constrained_photometric_weight;
  IcpResult textured = surfit::Register(frame, model, reference_from_initial, with_intensities);
  if (!textured.Succeeded()) return estimate;
  if (estimate.icp.Succeeded()) {
    textured.target_from_source = MovedAlongWeakDirections(
        estimate.icp, textured.target_from_source, kWeakDirections * options_.min_turn_eigenvalue);
  }
  estimate.icp = std::move(textured);
  estimate.options = std::move(with_intensities);
  return estimate;
}

Tracked FrameRegistration::Validate(const PreprocessedFrame& frame, const Target& target,
                                    const Estimate& estimate) const {
  const ReferenceView& reference = target.reference;
  const FramePyramid& model = reference.view.pyramid;
  const auto compare_at = [&](const Rigid3d& model_from_frame) {
    return CompareViews(frame.surface(), frame.images.color, model.levels.front(), reference.grey,
                        target.icp.error_model, model_from_frame);
  };
  const auto moving_at = [&](const Rigid3d& model_from_frame, const ViewComparison& views) {
    return regions_.Find(frame.surface(), views, reference.world_from_view * model_from_frame,
                         frame.images.stamp_s);
  };
  Tracked tracked;
  Estimate best = estimate;
  const Rigid3d& model_from_frame = estimate.icp.target_from_source;
  ViewComparison views = compare_at(model_from_frame);
  tracked.moving = moving_at(model_from_frame, views);
  if (!tracked.moving.empty() && target.motion.IsInertial()) {
    // A wrong inertial prior makes static surfaces look like moving ones. Fewer cells are
    // more likely.
    CellMask by_data = moving_at(estimate.registered, compare_at(estimate.registered));
    if (CountCells(by_data) < CountCells(tracked.moving)) tracked.moving = std::move(by_data);
  }
  FramePyramid unmoved;
  if (!tracked.moving.empty()) {
    unmoved = Without(frame.view.pyramid, tracked.moving);
    best = MostLikelyPose(unmoved, target, model_from_frame);
    views = compare_at(best.icp.target_from_source);
  }
  if (best.covariance) {
    tracked.motion_covariance =
        In(best.icp.target_from_source.Inverse(), {Rigid3d(), *best.covariance}).covariance;
  }
  const Matrix6d from_camera = IncrementTransform(best.registered);
  tracked.world_from_registered = reference.world_from_view * best.registered;
  tracked.registered_information =
      from_camera.transpose() * InformationWithoutSlides(best.icp) * from_camera;
  tracked.prior_squared_difference = best.squared_difference;
  tracked.icp = std::move(best.icp);
  tracked.quality.is_weakly_constrained = best.is_weakly_constrained;
  tracked.world_from_camera = reference.world_from_view * tracked.icp.target_from_source;
  const int moving = views.CountInFront(tracked.moving);
  tracked.moving_ratio = views.points > 0 ? static_cast<double>(moving) / views.points : 0;
  tracked.behind_ratio =
      views.compared > 0 ? static_cast<double>(views.behind) / views.compared : 0;
  tracked.verdict = ValidateRegistration(tracked.icp, views, moving, options_);
  if (tracked.verdict != Verdict::kAccepted) {
    views.alike = 1;
    tracked.is_color_contradicted =
        ValidateRegistration(tracked.icp, views, moving, options_) == Verdict::kAccepted;
  }
  if (tracked.verdict == Verdict::kRejected) return tracked;
  tracked.icp.degenerate_directions = std::move(best.degenerate_directions);
  tracked.state =
      tracked.icp.degenerate_directions.empty() ? FrameState::kTracked : FrameState::kDegenerate;
  if (tracked.state == FrameState::kDegenerate) return tracked;
  const FramePyramid& registered = tracked.moving.empty() ? frame.view.pyramid : unmoved;
  if (const std::optional<Matrix6d> covariance =
          CovarianceByBlocks(registered, model, best.registered, target.icp)) {
    tracked.registered_covariance =
        In(best.registered.Inverse(), {Rigid3d(), *covariance}).covariance;
  }
  return tracked;
}

}  // namespace surfit
