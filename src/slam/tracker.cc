#include "slam/tracker.h"

#include <algorithm>
#include <utility>

#include "surfit/core/trace.h"
#include "surfit/registration/far_registration.h"

namespace surfit {
namespace {

// Of lost frames the first five are looked for, and then every fifth: that takes as long as
// tracking tens of frames.
constexpr int kSearchStride = 5;

// What two views must show to be looked at in the map: its surfaces are to agree in any case, and
// motion blurs colours.
FitCriteria ShapesAlone() {
  FitCriteria fit = InitializeOptions::FrameCriteria();
  fit.min_value_correlation = fit.min_detail_correlation = -1;
  return fit;
}

// As a pose found forwards and one found backwards must.
bool Agree(const Tracked& a, const Tracked& b) {
  const FitCriteria criteria;
  const Rigid3d between = a.world_from_camera.Inverse() * b.world_from_camera;
  return between.translation.norm() <= criteria.max_disagreement_m &&
         RotationAngle(between.rotation) <= criteria.max_disagreement_rad;
}

}  // namespace

Tracker::Tracker(const SlamOptions& options, const Rigid3d& world_from_first_camera)
    : options_(options), last_{{}, world_from_first_camera} {}

bool Tracker::Repeats(const RgbdFrame& frame) {
  const bool repeats = has_started_ && frame.depth_m == last_depth_m_;
  last_depth_m_ = frame.depth_m;
  return repeats;
}

bool Tracker::HasEnoughDepth(const PreparedFrame& frame) const {
  const Image<float>& normal_z = frame.surface().normal.z;
  const auto points =
      std::count_if(normal_z.begin(), normal_z.end(), [](float z) { return z < 0; });
  return points >= options_.icp.min_inliers;
}

Rigid3d Tracker::Predict(const PreparedFrame& frame) const {
  if (options_.motion_model == "so3") {
    const ViewPair views = {frame.view.pyramid, frame.view.color, last_.view.pyramid,
                            last_.view.color};
    return last_.world_from_view * AlignRotation(views, Rigid3d());
  }
  // After a loss the motion is unknown: start where the camera was last seen.
  if (lost_count_ > 0 || options_.motion_model == "constant_pose") return last_.world_from_view;
  return last_.world_from_view * last_from_next_;
}

Tracked Tracker::Start(const PreparedFrame& frame) const {
  Tracked tracked;
  tracked.state = HasEnoughDepth(frame) ? FrameState::kFirst : FrameState::kLost;
  tracked.world_from_camera = last_.world_from_view;
  return tracked;
}

Tracked Tracker::Repeat() const {
  Tracked tracked;
  tracked.state = lost_count_ > 0 ? FrameState::kLost : FrameState::kFrozen;
  tracked.world_from_camera = last_.world_from_view;
  return tracked;
}

Tracked Tracker::Track(const PreparedFrame& frame, const ReferenceView& reference,
                       const Rigid3d& world_from_predicted) const {
  IcpOptions icp_options = options_.icp;
  if (is_poorly_held_) icp_options.min_source_rows = 0;
  return RegisterTo(reference, frame, world_from_predicted, icp_options);
}

Tracked Tracker::RegisterTo(const ReferenceView& reference, const PreparedFrame& frame,
                            const Rigid3d& world_from_start, const IcpOptions& icp_options) const {
  Tracked tracked;
  tracked.icp = Register(frame.view.pyramid, reference.view.pyramid,
                         reference.world_from_view.Inverse() * world_from_start, icp_options);
  tracked.world_from_camera = reference.world_from_view * tracked.icp.target_from_source;
  if (!IsBelievable(tracked.icp)) return tracked;
  tracked.state =
      tracked.icp.free_directions.empty() ? FrameState::kTracked : FrameState::kDegenerate;
  return tracked;
}

bool Tracker::IsBelievable(const IcpResult& icp) const {
  const bool is_degenerate = icp.termination == Termination::kSingularSystem;
  return (icp.Succeeded() || is_degenerate) && icp.inlier_share >= options_.min_inlier_share &&
         icp.rmse_m <= options_.max_rmse_m;
}

bool Tracker::IsDoubtful(const Tracked& tracked) const {
  return !tracked.is_held() ||
         (doubts() && (needs_search_ || tracked.icp.inlier_share < options_.sure_inlier_share));
}

Tracked Tracker::Better(Tracked tracked, std::optional<Tracked> found) const {
  if (found) return tracked.is_held() && Agree(tracked, *found) ? tracked : *std::move(found);
  if (doubts() && lost_count_ > 0) tracked.state = FrameState::kLost;
  return tracked;
}

std::optional<Rigid3d> Tracker::FindFromLast(const PreparedFrame& frame) const {
  if (options_.initialize == "identity") return std::nullopt;
  const bool is_soon = doubts() && lost_count_ < kSearchStride;
  if (!is_soon && lost_count_ % kSearchStride != 0) return std::nullopt;
  if (!HasEnoughDepth(frame)) return std::nullopt;
  const TraceSlice slice("find_again", frame.images.index);
  InitializeOptions initialization;
  initialization.method = options_.initialize;
  if (doubts()) initialization.fit = ShapesAlone();
  const FarVerdict found = RegisterFar(frame.view, last_.view, initialization, FarIcpOptions());
  if (!found.accepted()) return std::nullopt;
  return last_.world_from_view * found.target_from_source;
}

std::optional<Tracked> Tracker::Confirm(const PreparedFrame& frame, const ReferenceView& reference,
                                        const Rigid3d& world_from_found) const {
  Tracked tracked = RegisterTo(reference, frame, world_from_found, options_.icp);
  if (!tracked.is_held()) return std::nullopt;
  tracked.found_again = true;
  return tracked;
}

void Tracker::Keep(PreparedFrame frame, const Tracked& tracked) {
  // The way over lost frames is not one frame's motion, nor is a jump.
  const bool is_next = has_started_ && lost_count_ == 0 && !tracked.found_again;
  last_from_next_ =
      is_next ? last_.world_from_view.Inverse() * tracked.world_from_camera : Rigid3d();
  needs_search_ = tracked.found_again;
  is_poorly_held_ =
      !tracked.icp.iterations.empty() && tracked.icp.eigenvalues[0] < options_.min_turn_eigenvalue;
  if (options_.tracking == "frame_to_frame" || options_.initialize != "identity" ||
      options_.motion_model == "so3") {
    last_.view = std::move(frame.view);
  }
  last_.world_from_view = tracked.world_from_camera;
  has_started_ = true;
  lost_count_ = 0;
}

void Tracker::Move(const Rigid3d& new_from_old_world) {
  last_.world_from_view = new_from_old_world * last_.world_from_view;
}

}  // namespace surfit
