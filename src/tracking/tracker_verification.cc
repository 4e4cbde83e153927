// Confirms uncertain and tentative poses by a second registration.
#include <utility>

#include "tracking/pose_validation.h"
#include "tracking/tracker.h"

namespace surfit {
namespace {

// Maximum time to the second frame without verification, s. Hand motion in this time is small.
constexpr double kMaxUnverified_s = 0.05;

}  // namespace

// Searches the pose of an uncertain frame. A step that no hand makes is replaced by a smaller step,
// if the search finds one.
Tracked Tracker::Verified(const PreprocessedFrame& frame, const Prediction& prediction,
                          Tracked tracked) const {
  if (IsUncertain(frame, prediction, tracked)) return Search(frame, std::move(tracked));
  if (!IsImpossible(frame, tracked)) return tracked;
  Tracked found = Search(frame, tracked);
  return found.has_pose() && !IsImpossible(frame, found) ? found : tracked;
}

Tracked Tracker::Search(const PreprocessedFrame& frame, Tracked tracked) const {
  return search_.Search(
      frame, {state_, last_, SecondsTo(frame), submap_, lost_with_depth_, ExpectedPose(frame)},
      std::move(tracked));
}

// Returns whether the pose is a step that no hand makes.
bool Tracker::IsImpossible(const PreprocessedFrame& frame, const Tracked& tracked) const {
  return options_.VerifiesBySearch() && tracked.has_pose() &&
         motion_model_.IsImpossible(
             state_, last_.world_from_view.Inverse() * tracked.world_from_camera, SecondsTo(frame));
}

// Returns std::nullopt without a tentative pose, or if the frame does not confirm it. `tracked` is
// then lost if it was registered to the map of another submap.
std::optional<Tracked> Tracker::CompareWithTentative(const PreprocessedFrame& frame,
                                                     Tracked* tracked) {
  if (!state_.IsTentative()) return std::nullopt;
  state_ = Next(state_, TrackingEvent::kTentativeCompared);
  TentativePose tentative = *std::move(tentative_);
  tentative_.reset();
  std::optional<Tracked> confirmed = Confirmed(frame, *tracked, tentative);
  if (confirmed) {
    confirmed->confirmed = std::move(tentative);
  } else if (tentative.submap != submap_) {
    views_->UseSubmap(submap_);
    regions_.Forget();
    tracked->state = FrameState::kLost;
  }
  return confirmed;
}

// Registers the frame to the frame with the tentative pose. Returns std::nullopt if the poses
// differ.
std::optional<Tracked> Tracker::Confirmed(const PreprocessedFrame& frame, const Tracked& tracked,
                                          const TentativePose& tentative) const {
  if (!tracked.has_pose() || tracked.verdict != Verdict::kAccepted) return std::nullopt;
  PreprocessedFrame rest = frame;
  rest.view.pyramid = Without(std::move(rest.view.pyramid), tracked.moving);
  const Tracked from_there =
      registration_.Register(rest, tentative.view, tracked.world_from_camera, options_.icp);
  if (!from_there.has_pose() ||
      !AreOnePlace(from_there.world_from_camera, tracked.world_from_camera)) {
    return std::nullopt;
  }
  Tracked confirmed = tracked;
  confirmed.found_by_search = true;
  confirmed.keyframe = tentative.keyframe;
  confirmed.keyframe_frame = tentative.keyframe_frame;
  confirmed.submap = tentative.submap;
  if (confirmed.keyframe >= 0) confirmed.state = FrameState::kRelocalized;
  return confirmed;
}

bool Tracker::IsUncertain(const PreprocessedFrame& frame, const Prediction& prediction,
                          const Tracked& tracked) const {
  if (!tracked.has_pose() || tracked.verdict == Verdict::kUncertain || state_.NeedsSearch())
    return true;
  return options_.VerifiesBySearch() &&
         (state_.NeedsVerification() ||
          (state_.last.is_first && SecondsTo(frame) > kMaxUnverified_s) ||
          tracked.icp.inlier_ratio < options_.confident_inlier_ratio ||
          IsFar(frame, prediction.world_from_camera) || IsFar(frame, tracked.world_from_camera));
}

bool Tracker::IsFar(const PreprocessedFrame& frame, const Rigid3d& world_from_camera) const {
  const Rigid3d motion = last_.world_from_view.Inverse() * world_from_camera;
  return ImageShift(motion, frame.view.pyramid.levels.back()) > options_.max_view_shift;
}

}  // namespace surfit
