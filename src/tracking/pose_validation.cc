#include "tracking/pose_validation.h"

#include <optional>

namespace surfit {
namespace {

// Bounds on (cells in front of or behind the model) / compared cells. For 99 % of correct poses,
// the ratio is below kSureRatio. For errors of more than 10 cm, it is above kMostRatio, unless
// wrong frames were fused before.
constexpr double kSureRatio = 0.12, kMostRatio = 0.25;
// Bounds on the same ratio without moving cells.
constexpr double kSureRest = 0.08, kMostRest = 0.16;
constexpr double kSureAlike = 0.5, kMinAlike = 0.3;

// Bound on cells behind the model / compared cells. Beside a door frame, the ratio is below 0.2
// %. At a wrong pose, this ratio and the ratio in front are similar, and their sum is above 12
// %.
constexpr double kMaxBehindNewest = 0.02;

// A pose with few inliers is uncertain instead of rejected if these bounds hold. Points that no
// view can compare are then the reason for the few inliers: they are on moving objects, on new
// surfaces, or too distant. The bounds are inliers per correspondence, cells at the model surface
// per cell with depth, and the inlier ratio relative to TrackingOptions::min_inlier_ratio.
constexpr double kMinInliersPerPair = 0.8, kMinAtSurface = 0.25, kMinRelativeInliers = 0.36;

bool HasInliers(const IcpResult& icp, const TrackingOptions& options) {
  return icp.inlier_ratio >= options.min_inlier_ratio;
}

bool IsConstrainedByFewInliers(const IcpResult& icp, const ViewComparison& views,
                               const TrackingOptions& options) {
  return icp.degenerate_directions.empty() && icp.eigenvalues[0] >= options.min_turn_eigenvalue &&
         icp.inlier_ratio >= kMinRelativeInliers * options.min_inlier_ratio &&
         icp.inlier_count >= kMinInliersPerPair * icp.system.pair_count &&
         views.compared - views.in_front - views.behind >= kMinAtSurface * views.points;
}

bool IsRegistered(const IcpResult& icp, const ViewComparison& views,
                  const TrackingOptions& options) {
  const bool is_degenerate = icp.termination == Termination::kSingularSystem;
  const bool has_inliers =
      HasInliers(icp, options) || IsConstrainedByFewInliers(icp, views, options);
  return (icp.Succeeded() || is_degenerate) && has_inliers && icp.rmse_m <= options.max_rmse_m;
}

bool AreWithin(double distance_m, double angle_rad, const Rigid3d& a, const Rigid3d& b) {
  const Rigid3d between = a.Inverse() * b;
  return between.translation.norm() <= distance_m && RotationAngle(between.rotation) <= angle_rad;
}

}  // namespace

Verdict ValidateRegistration(const IcpResult& icp, const ViewComparison& views, int moving,
                             const TrackingOptions& options) {
  if (!IsRegistered(icp, views, options)) return Verdict::kRejected;
  if (views.compared <= moving) return Verdict::kRejected;
  const double all = static_cast<double>(views.in_front + views.behind) / views.compared;
  const double rest =
      static_cast<double>(views.in_front - moving + views.behind) / (views.compared - moving);
  const bool agrees = all <= kSureRatio || (moving > 0 && rest <= kSureRest);
  if (views.alike < kMinAlike) return Verdict::kRejected;
  if (agrees && views.alike >= kSureAlike && HasInliers(icp, options)) return Verdict::kAccepted;
  const bool may_agree =
      all <= kSureRatio ||
      (views.alike >= kSureAlike && (all <= kMostRatio || (moving > 0 && rest <= kMostRest)));
  return agrees || may_agree ? Verdict::kUncertain : Verdict::kRejected;
}

bool MayShowNewSurfaces(const Tracked& tracked) {
  return tracked.verdict != Verdict::kAccepted && tracked.behind_ratio <= kMaxBehindNewest;
}

MotionBound PossibleMotion(double seconds) {
  constexpr double kAtOnce_m = 0.1, kMetresPerSecond = 3;
  constexpr double kAtOnce_rad = 0.2, kRadPerSecond = 6;
  return {kAtOnce_m + kMetresPerSecond * seconds, kAtOnce_rad + kRadPerSecond * seconds};
}

bool AreOnePlace(const Rigid3d& a, const Rigid3d& b) { return AreWithin(0.05, 0.05, a, b); }

bool AgreeClosely(const Rigid3d& a, const Rigid3d& b) {
  const FitCriteria criteria;
  return AreWithin(criteria.max_disagreement_m, criteria.max_disagreement_rad, a, b);
}

Tracked ValidateByFeatures(const PreprocessedFrame& frame, Tracked tracked,
                           const CameraMotion& since_last, FeatureWatch* features) {
  const double stamp_s = frame.images.stamp_s;
  features->Follow(frame.view,
                   tracked.has_pose() ? std::optional(tracked.world_from_camera) : std::nullopt,
                   stamp_s);
  if (!tracked.has_pose()) return tracked;
  if (!features->IsDue(stamp_s) && !tracked.found_by_search) return tracked;
  const FeatureMotion motion =
      features->Check(frame.view, tracked.moving, {tracked.world_from_camera, since_last}, stamp_s);
  tracked.has_two_motions = motion.HasTwoMotions();
  if (motion.IsRejected()) tracked.state = FrameState::kLost;
  return tracked;
}

}  // namespace surfit
