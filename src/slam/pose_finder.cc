#include "slam/pose_finder.h"

#include <utility>

#include "core/trace.h"

namespace surfit {
namespace {

// Of lost frames every third is looked for among keyframes, which takes as long as tracking many.
constexpr int kRelocalizeStride = 3;

bool HasIntensities(const PreparedFrame& frame) { return !frame.surface().intensity.empty(); }

}  // namespace

// Where all that was known of the camera has failed for long, a new map begins.
Tracked PoseFinder::Find(const PreparedFrame& frame, StageTimes* times) {
  if (!tracker_->has_started()) return tracker_->Start(frame);
  Tracked tracked = TrackFromPrediction(frame, times);
  if (!tracked.is_held() && !tracker_->has_proposal() && IsNewMapDue(frame)) {
    tracked.state = FrameState::kNewMap;
    tracked.moving = {};
    tracked.world_from_camera = backend_->BeginSubmap(tracker_->last().world_from_view);
  }
  return tracked;
}

void PoseFinder::DrawForNext(const RgbdFrame& last, StageTimes* times) {
  const std::optional<Rigid3d> world_from_next = tracker_->PredictNext();
  if (tracks_frame_to_frame() || !world_from_next) return;
  const StageTimer timer("draw_ahead", last.index, &times->predict_ms);
  UpdateView(*world_from_next, tracker_->needs_intensities() && !last.color.empty());
}

// Intensities are compared more finely than surfaces: with views that frames share the largest
// error before textured walls is twice as large.
bool PoseFinder::UpdateView(const Rigid3d& world_from_predicted, bool has_intensities) {
  return mapper_->UpdateView(world_from_predicted, tracker_->needs_all() || has_intensities,
                             has_intensities);
}

// Registers the frame from where the camera is expected, to what is expected to be seen there;
// where that fails or is in doubt, looks for it from afar.
Tracked PoseFinder::TrackFromPrediction(const PreparedFrame& frame, StageTimes* times) {
  const int index = frame.images.index;
  Rigid3d world_from_predicted;
  bool has_own_view = tracks_frame_to_frame();
  {
    const StageTimer timer("predict", index, &times->predict_ms);
    world_from_predicted = tracker_->Predict(frame);
    if (!has_own_view) {
      has_own_view = UpdateView(world_from_predicted, HasIntensities(frame));
    }
  }
  const ReferenceView& reference = tracks_frame_to_frame() ? tracker_->last() : mapper_->view();
  const StageTimer timer("track", index, &times->track_ms);
  Tracked tracked = tracker_->Track(frame, reference, world_from_predicted);
  if (tracker_->MayShowNewest(tracked)) tracked = AgainstNewest(frame, std::move(tracked));
  const bool is_far = tracker_->doubts() && (IsFar(frame, world_from_predicted) ||
                                             IsFar(frame, tracked.world_from_camera));
  if (std::optional<Tracked> confirmed = ConfirmProposal(frame, tracked)) {
    tracked = *std::move(confirmed);
  } else if (is_far || tracker_->IsDoubtful(tracked)) {
    tracked = SearchFor(frame, std::move(tracked));
  }
  if (!tracked.is_held() && on_lost_) {
    on_lost_({index, frame.view.pyramid, reference.view.pyramid, frame.images.color,
              reference.view.color, reference.world_from_view.Inverse() * world_from_predicted,
              tracked.icp});
  }
  tracked.has_own_view = has_own_view;
  if (tracked.is_held()) {
    tracked.world_from_camera =
        tracker_->PoseByItsMotion(frame, mapper_->sensor().readout_s, tracked);
  }
  return tracked;
}

// A frame that is not believed may show what the frames before have begun to map: then it agrees
// with that, at the same pose.
Tracked PoseFinder::AgainstNewest(const PreparedFrame& frame, Tracked tracked) {
  const Rigid3d& pose = tracked.world_from_camera;
  const ReferenceView newest = mapper_->DrawNewest(pose, HasIntensities(frame));
  return tracker_->Backed(std::move(tracked), tracker_->Track(frame, newest, pose));
}

// A doubtful frame from afar. Where another run has ended the camera need not be. What is found
// without being sure is proposed, and lost.
Tracked PoseFinder::SearchFor(const PreparedFrame& frame, Tracked tracked) {
  if (!tracker_->MayFollow(frame)) tracked.state = FrameState::kLost;
  tracked = tracker_->Better(std::move(tracked), FindAgain(frame));
  if (!tracked.is_held()) {
    if (std::optional<Tracked> found = Relocalize(frame)) tracked = *std::move(found);
  }
  if (tracked.is_held() && tracker_->NeedsConfirmation(frame, tracked)) {
    tracker_->Propose(frame, tracked);
    tracked.state = FrameState::kLost;
  } else if (tracked.is_held() && tracked.keyframe >= 0) {
    backend_->AfterRelocalization(tracked.keyframe);
  }
  return tracked;
}

// A frame that was tracked from where the one before was found, if that was not sure.
std::optional<Tracked> PoseFinder::ConfirmProposal(const PreparedFrame& frame,
                                                   const Tracked& tracked) {
  if (!tracker_->has_proposal()) return std::nullopt;
  std::optional<Tracked> confirmed = tracker_->ConfirmProposal(frame, tracked);
  if (confirmed && confirmed->keyframe >= 0) backend_->AfterRelocalization(confirmed->keyframe);
  return confirmed;
}

// Farther from the last frame than tracking surely follows.
bool PoseFinder::IsFar(const PreparedFrame& frame, const Rigid3d& world_from_camera) const {
  const Rigid3d motion = tracker_->last().world_from_view.Inverse() * world_from_camera;
  return ImageShift(motion, frame.view.pyramid.levels.back()) > options_.max_view_shift;
}

// From the last good frame as far as the views tell, and from there against the map.
std::optional<Tracked> PoseFinder::FindAgain(const PreparedFrame& frame) {
  const std::optional<Rigid3d> world_from_found = tracker_->FindFromLast(frame);
  return world_from_found ? Confirm(frame, *world_from_found) : std::nullopt;
}

// By a keyframe that shows the same place, and from there against the map.
std::optional<Tracked> PoseFinder::Relocalize(const PreparedFrame& frame) {
  if (!options_.loops.enabled || tracker_->lost_count() % kRelocalizeStride != 0)
    return std::nullopt;
  if (!tracker_->HasEnoughDepth(frame)) return std::nullopt;
  const Relocalization found = backend_->Find(frame.view);
  if (!found.found()) return std::nullopt;
  if (may_change_map_) {
    mapper_->WakeAround(backend_->FrameOfKeyframe(found.keyframe), frame.images.index);
  }
  std::optional<Tracked> tracked = Confirm(frame, found.world_from_camera);
  if (!tracked) return std::nullopt;
  tracked->state = FrameState::kRelocalized;
  tracked->keyframe = found.keyframe;
  return tracked;
}

std::optional<Tracked> PoseFinder::Confirm(const PreparedFrame& frame,
                                           const Rigid3d& world_from_found) {
  if (tracks_frame_to_frame()) return tracker_->Confirm(frame, tracker_->last(), world_from_found);
  return tracker_->Confirm(frame, mapper_->Draw(world_from_found, HasIntensities(frame)),
                           world_from_found);
}

bool PoseFinder::IsNewMapDue(const PreparedFrame& frame) const {
  const int after = options_.loops.new_map_after;
  return options_.loops.enabled && may_change_map_ && after > 0 &&
         tracker_->lost_count() + 1 >= after && tracker_->HasEnoughDepth(frame);
}

}  // namespace surfit
