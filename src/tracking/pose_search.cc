#include "tracking/pose_search.h"

#include <utility>

#include "core/trace.h"
#include "tracking/pose_validation.h"

namespace surfit {
namespace {

// A frame is tracked from the last pose of a given map if it is at most this much later.
constexpr double kFollows_s = 1;

// Moving objects are left out of the search if the last pose is at most this old. After a longer
// time, cells of a wrong pose look like moving objects.
constexpr double kContinuous_s = 0.25;

bool HasMovingObjects(const SearchStart& start, const Tracked& tracked) {
  return tracked.has_pose() && start.seconds <= kContinuous_s && !tracked.moving.empty();
}

// View of a frame without its moving objects.
ColoredView Unmoved(const PreprocessedFrame& frame, const Tracked& tracked) {
  return {Without(frame.view.pyramid, tracked.moving), frame.view.color};
}

// After the first lost frames, every kSearchStride-th lost frame is searched. A search takes as
// long as ten registrations.
constexpr int kSearchStride = 5;

// Rank of the keyframe that is verified for a lost frame: 0, 1, 0, 2, 0, 3, ... The most similar
// keyframe is verified for every second lost frame.
int RankOf(int lost_frames) { return lost_frames % 2 == 0 ? 0 : (lost_frames + 1) / 2; }

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
  if (tracked.submap && *tracked.submap != start.submap) return true;
  if (start.state.lost_frames == 0 && !tracked.found_by_search) return false;
  if (!tracked.has_second) return true;
  const Rigid3d motion = start.last.world_from_view.Inverse() * tracked.world_from_camera;
  return start.state.lost_frames >= kSearchStride || !PossibleMotion(start.seconds).Allows(motion);
}

}  // namespace

Tracked PoseSearch::Search(const PreprocessedFrame& frame, const SearchStart& start,
                           Tracked tracked) const {
  const bool follows =
      start.state.is_localised || (start.seconds > 0 && start.seconds < kFollows_s);
  if (!follows) tracked.state = FrameState::kLost;
  std::optional<Tracked> found = FromLastFrame(frame, start, tracked);
  if (!found && StaticPartAgrees(frame, start, tracked)) {
    tracked.verdict = Verdict::kAccepted;
    tracked.has_second = true;
  }
  tracked = Better(start, std::move(tracked), std::move(found));
  if (!tracked.has_pose()) {
    if (std::optional<Tracked> again = ByKeyframes(frame, start)) tracked = *std::move(again);
  }
  if (tracked.has_pose() && NeedsConfirmation(start, tracked)) {
    tracked.tentative = {Without(frame.measured, tracked.moving),
                         {Unmoved(frame, tracked), tracked.world_from_camera, {}},
                         tracked.icp,
                         tracked.keyframe,
                         tracked.keyframe_frame,
                         tracked.submap.value_or(start.submap)};
    tracked.keyframe = -1;
    tracked.state = FrameState::kLost;
  }
  return tracked;
}

bool PoseSearch::IsDue(const PreprocessedFrame& frame, const SearchStart& start) const {
  if (options_.initialize == "identity" || !start.state.is_localised) return false;
  const bool is_soon = options_.VerifiesBySearch() && start.lost_frames < kSearchStride;
  return (is_soon || start.lost_frames % kSearchStride == 0) && HasEnoughDepth(frame, options_.icp);
}

bool PoseSearch::HasFeatures() const { return relocalizer_ && !options_.IsFrameToFrame(); }

std::optional<Rigid3d> PoseSearch::ByFeatures(const PreprocessedFrame& frame,
                                              const SearchStart& start,
                                              const Tracked& tracked) const {
  if (!HasFeatures()) return std::nullopt;
  const std::optional<Rigid3d> last_from_frame =
      HasMovingObjects(start, tracked)
          ? relocalizer_->RegisterTo(start.last.view, Unmoved(frame, tracked))
          : relocalizer_->RegisterTo(start.last.view, frame.view);
  if (!last_from_frame) return std::nullopt;
  return start.last.world_from_view * *last_from_frame;
}

std::optional<Tracked> PoseSearch::FromLastFrame(const PreprocessedFrame& frame,
                                                 const SearchStart& start,
                                                 const Tracked& tracked) const {
  if (!IsDue(frame, start)) return std::nullopt;
  const std::optional<Rigid3d> by_features = ByFeatures(frame, start, tracked);
  if (by_features && tracked.has_pose() && AgreeClosely(tracked.world_from_camera, *by_features)) {
    return tracked;
  }
  const bool is_first = start.lost_frames == 0;
  if (!HasFeatures() || (is_first && options_.VerifiesBySearch())) {
    if (std::optional<Tracked> found = Globally(frame, start, tracked)) return found;
  }
  return by_features ? Confirm(frame, start, *by_features) : std::nullopt;
}

// Features and surfaces of moving objects are not used, because these objects are also in the last
// frame if they were not detected there.
std::optional<Tracked> PoseSearch::Globally(const PreprocessedFrame& frame,
                                            const SearchStart& start,
                                            const Tracked& tracked) const {
  const TrackingState& state = start.state;
  const bool verifies = options_.VerifiesBySearch();
  const TraceSlice slice("find_again", frame.images.index);
  InitializeOptions initialization;
  initialization.method = options_.initialize;
  // On a single plane, the pose is not unique without colours.
  const bool is_plain = state.last.is_weakly_constrained && options_.acceleration_m_per_s2 > 0;
  if (verifies && !is_plain) initialization.fit = ShapesAlone();
  IcpOptions icp_options = GlobalIcpOptions();
  icp_options.min_source_rows = options_.icp.min_source_rows;
  const MotionBound bound = PossibleMotion(start.seconds);
  const auto register_view = [&](const ColoredView& view) {
    return RegisterGlobally(view, start.last.view, initialization, icp_options, bound);
  };
  GlobalRegistrationResult found;
  if (HasMovingObjects(start, tracked)) found = register_view(Unmoved(frame, tracked));
  if (!found.accepted()) found = register_view(frame.view);
  if (!found.accepted()) return std::nullopt;
  const Rigid3d world_from_found = start.last.world_from_view * found.target_from_source;
  if (tracked.has_pose() && AgreeClosely(tracked.world_from_camera, world_from_found)) {
    return tracked;
  }
  return Confirm(frame, start, world_from_found);
}

// Global registration fails if a moving object covers much of both views, or if little of the views
// overlaps. The static part of the frame is then registered to that of the last frame.
bool PoseSearch::StaticPartAgrees(const PreprocessedFrame& frame, const SearchStart& start,
                                  const Tracked& tracked) const {
  const bool is_partial =
      !tracked.moving.empty() || tracked.icp.inlier_ratio < options_.min_inlier_ratio;
  if (!tracked.has_pose() || tracked.verdict != Verdict::kUncertain || !is_partial ||
      options_.IsFrameToFrame() || options_.initialize == "identity" || !start.state.is_localised ||
      start.seconds > kContinuous_s) {
    return false;
  }
  const Rigid3d last_from_frame = start.last.world_from_view.Inverse() * tracked.world_from_camera;
  const IcpResult second = Register(Without(frame.view.pyramid, tracked.moving),
                                    start.last.view.pyramid, last_from_frame, options_.icp);
  return second.Succeeded() && second.degenerate_directions.empty() &&
         second.rmse_m <= options_.max_rmse_m &&
         AgreeClosely(second.target_from_source, last_from_frame);
}

std::optional<Tracked> PoseSearch::ByKeyframes(const PreprocessedFrame& frame,
                                               const SearchStart& start) const {
  if (!relocalizer_ || !HasEnoughDepth(frame, options_.icp)) return std::nullopt;
  const std::optional<KeyframePose> found =
      relocalizer_->Find(frame.view, RankOf(start.lost_frames));
  if (!found) return std::nullopt;
  views_->UseSubmap(found->submap);
  if (found->submap != start.submap) regions_->Forget();
  views_->ActivateAround(found->frame_index, frame.images.index);
  std::optional<Tracked> tracked = Confirm(frame, start, found->world_from_camera);
  if (!tracked) {
    views_->UseSubmap(start.submap);
    return std::nullopt;
  }
  tracked->state = FrameState::kRelocalized;
  tracked->keyframe = found->keyframe;
  tracked->keyframe_frame = found->frame_index;
  tracked->submap = found->submap;
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
