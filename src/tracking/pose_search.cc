#include "tracking/pose_search.h"

#include <utility>

#include "core/trace.h"
#include "tracking/pose_validation.h"

namespace surfit {
namespace {

// A frame is tracked from the last pose of a given map if it is at most this much later.
constexpr double kFollows_s = 1;

// After the first lost frames, every kSearchStride-th lost frame is searched. A search takes as
// long as ten registrations.
constexpr int kSearchStride = 5;

// Every kRelocalizeStride-th lost frame is relocalised.
constexpr int kRelocalizeStride = 3;

// Acceptance criteria without brightness, which motion blur changes.
FitCriteria ShapesAlone() {
  FitCriteria fit = InitializeOptions::FrameCriteria();
  fit.min_value_correlation = fit.min_detail_correlation = -1;
  return fit;
}

// Combines the poses of tracking and search. If they disagree, returns the search result,
// because a wrong pose of tracking may have as many inliers. A search result far from the
// predicted pose is ignored: it may be a place with similar appearance. Without a usable search
// result, an uncertain frame is lost.
Tracked Better(const SearchStart& start, Tracked tracked, std::optional<Tracked> found) {
  const bool is_unexpected =
      found && start.expected && !AreOnePlace(*start.expected, found->world_from_camera);
  if (found && !(tracked.has_pose() && is_unexpected)) {
    if (!tracked.has_pose() || !AgreeClosely(tracked.world_from_camera, found->world_from_camera))
      return *std::move(found);
    tracked.verdict = Verdict::kAccepted;
    tracked.has_second = true;
    return tracked;
  }
  if (tracked.verdict == Verdict::kUncertain) tracked.state = FrameState::kLost;
  return tracked;
}

// Returns whether the next frame must confirm the pose: after a long loss, after an implausible
// motion, or without a second registration.
bool NeedsConfirmation(const SearchStart& start, const Tracked& tracked) {
  if (!start.state.is_localised) return true;
  if (start.state.lost_frames == 0 && !tracked.found_by_search) return false;
  if (!tracked.has_second) return true;
  const Rigid3d motion = start.last.world_from_view.Inverse() * tracked.world_from_camera;
  return start.state.lost_frames >= kSearchStride || !IsPossibleMotion(motion, start.seconds);
}

}  // namespace

Tracked PoseSearch::Search(const PreprocessedFrame& frame, const SearchStart& start,
                           Tracked tracked) const {
  const bool follows =
      start.state.is_localised || (start.seconds > 0 && start.seconds < kFollows_s);
  if (!follows) tracked.state = FrameState::kLost;
  tracked = Better(start, std::move(tracked), FromLastFrame(frame, start));
  if (!tracked.has_pose()) {
    if (std::optional<Tracked> found = ByKeyframes(frame, start)) tracked = *std::move(found);
  }
  if (tracked.has_pose() && NeedsConfirmation(start, tracked)) {
    ColoredView rest = {Without(frame.view.pyramid, tracked.moving), frame.view.color};
    tracked.tentative = {Without(frame.measured, tracked.moving),
                         {std::move(rest), tracked.world_from_camera, {}},
                         tracked.icp,
                         tracked.keyframe};
    tracked.keyframe = -1;
    tracked.state = FrameState::kLost;
  }
  return tracked;
}

std::optional<Tracked> PoseSearch::FromLastFrame(const PreprocessedFrame& frame,
                                                 const SearchStart& start) const {
  const TrackingState& state = start.state;
  if (options_.initialize == "identity" || !state.is_localised) return std::nullopt;
  const bool verifies = options_.VerifiesBySearch();
  const bool is_soon = verifies && state.lost_frames < kSearchStride;
  if (!is_soon && state.lost_frames % kSearchStride != 0) return std::nullopt;
  if (!HasEnoughDepth(frame, options_.icp)) return std::nullopt;
  const TraceSlice slice("find_again", frame.images.index);
  InitializeOptions initialization;
  initialization.method = options_.initialize;
  // On a single plane, the pose is not unique without colours.
  const bool is_plain = state.last.is_weakly_constrained && options_.acceleration_m_per_s2 > 0;
  if (verifies && !is_plain) initialization.fit = ShapesAlone();
  IcpOptions icp_options = GlobalIcpOptions();
  icp_options.min_source_rows = options_.icp.min_source_rows;
  const GlobalRegistrationResult found =
      RegisterGlobally(frame.view, start.last.view, initialization, icp_options);
  if (!found.accepted()) return std::nullopt;
  return Confirm(frame, start, start.last.world_from_view * found.target_from_source);
}

std::optional<Tracked> PoseSearch::ByKeyframes(const PreprocessedFrame& frame,
                                               const SearchStart& start) const {
  if (!relocalizer_ || start.state.lost_frames % kRelocalizeStride != 0) return std::nullopt;
  if (!HasEnoughDepth(frame, options_.icp)) return std::nullopt;
  const std::optional<KeyframePose> found = relocalizer_->Find(frame.view);
  if (!found) return std::nullopt;
  views_->ActivateAround(found->frame_index, frame.images.index);
  std::optional<Tracked> tracked = Confirm(frame, start, found->world_from_camera);
  if (!tracked) return std::nullopt;
  tracked->state = FrameState::kRelocalized;
  tracked->keyframe = found->keyframe;
  return tracked;
}

std::optional<Tracked> PoseSearch::Confirm(const PreprocessedFrame& frame, const SearchStart& start,
                                           const Rigid3d& world_from_found) const {
  const auto register_to = [&](const ReferenceView& reference) {
    return registration_.Register(frame, reference, world_from_found, options_.icp);
  };
  Tracked tracked = options_.IsFrameToFrame()
                        ? register_to(start.last)
                        : register_to(views_->ViewAt(world_from_found, frame.HasIntensities()));
  if (!tracked.has_pose()) return std::nullopt;
  if (tracked.verdict == Verdict::kUncertain) {
    if (!AreOnePlace(tracked.world_from_camera, world_from_found)) return std::nullopt;
    tracked.verdict = Verdict::kAccepted;
  }
  tracked.found_by_search = tracked.has_second = true;
  return tracked;
}

}  // namespace surfit
