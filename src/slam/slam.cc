#include "surfit/slam/slam.h"

#include <glog/logging.h>

#include <utility>
#include <vector>

#include "slam/mapper.h"
#include "slam/tracker.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/core/trace.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/frame/prepare_frame.h"
#include "surfit/frame/rolling_shutter.h"
#include "surfit/slam/slam_state.h"

namespace surfit {
namespace {

// Of lost frames every third is looked for among keyframes, which takes as long as tracking many.
constexpr int kRelocalizeStride = 3;

// Made whole: the fusion knows nothing of loops.
SlamOptions Validated(SlamOptions options) {
  Validate(options);
  int& active_frames = options.fusion.active_frames;
  if (options.loops.enabled && active_frames == 0) active_frames = options.loops.active_frames;
  return options;
}

// The frames up to the last that were fused, about: one of so many is.
std::vector<int> FusedFrames(const std::vector<PosedFrame>& frames, int period) {
  std::vector<int> fused;
  for (std::size_t i = (frames.size() - 1) % period; i < frames.size(); i += period) {
    fused.push_back(frames[i].index);
  }
  return fused;
}

bool HasIntensities(const PreparedFrame& frame) { return !frame.surface().intensity.empty(); }

Tracked Given(const Rigid3d& world_from_camera) {
  Tracked tracked;
  tracked.state = FrameState::kGiven;
  tracked.world_from_camera = world_from_camera;
  return tracked;
}

FrameReport Report(const RgbdFrame& frame, const Tracked& tracked,
                   const std::optional<FusionReport>& fused, const StageTimes& times) {
  FrameReport report;
  report.index = frame.index;
  report.stamp_s = frame.stamp_s;
  report.state = tracked.state;
  report.world_from_camera = tracked.world_from_camera;
  report.found_again = tracked.found_again;
  report.has_own_view = tracked.has_own_view;
  report.moving_share = tracked.moving_share;
  report.is_apart = tracked.is_apart;
  report.moving = tracked.moving;
  report.icp = tracked.icp;
  report.is_fused = fused.has_value();
  if (fused) report.fusion = *fused;
  report.times = times;
  return report;
}

}  // namespace

std::string ToString(FrameState state) {
  switch (state) {
    case FrameState::kFirst:
      return "first";
    case FrameState::kTracked:
      return "tracked";
    case FrameState::kDegenerate:
      return "degenerate";
    case FrameState::kFrozen:
      return "frozen";
    case FrameState::kGiven:
      return "given";
    case FrameState::kLost:
      return "lost";
    case FrameState::kRelocalized:
      return "relocalised";
    case FrameState::kNewMap:
      return "new_map";
  }
  return "unknown";
}

// The tracker follows the camera, the mapper keeps the map, the backend closes loops.
class Slam::Pipeline {
 public:
  Pipeline(const DepthSensor& sensor, const SlamOptions& options,
           const Rigid3d& world_from_first_camera)
      : sensor_(sensor),
        options_(Validated(options)),
        tracker_(options_, world_from_first_camera),
        mapper_(sensor, options_) {
    sensor.Validate();
    if (options.loops.enabled || options.calibration.enabled) MakeBackend({});
  }

  Pipeline(const DepthSensor& sensor, SlamOptions options, SlamState state, StateUse use);

  FrameReport Process(const RgbdFrame& frame, const std::optional<Rigid3d>& given_pose);
  void UseLoopFinder(LoopFinder finder);
  void Finish();

  std::function<void(const FramePose&)>& on_pose() { return on_pose_; }
  std::function<void(const LostFrame&)>& on_lost() { return on_lost_; }
  const Mapper& mapper() const { return mapper_; }
  const Backend* backend() const { return backend_.get(); }
  void OnKeyframe(KeyframeCall call) { backend_->OnKeyframe(std::move(call)); }

 private:
  void MakeBackend(LoopFinder finder);
  void CorrectWorld(int frame_index, StageTimes* times);
  const RgbdFrame& AsSeen(const RgbdFrame& frame, const CameraMotion& motion);
  const RgbdFrame& AtRest(const RgbdFrame& frame, const CellMask& moving);
  PreparedFrame AtRest(PreparedFrame frame, const CellMask& moving);
  void Correct(const WorldCorrection& correction, int frame_index);
  void TellPose(const RgbdFrame& frame, const Tracked& tracked) const;
  Tracked Repeat(const RgbdFrame& frame);
  PreparedFrame Prepare(const RgbdFrame& frame, const CameraMotion& motion, StageTimes* times);
  Tracked Track(const PreparedFrame& frame, StageTimes* times);
  void DrawForNext(const RgbdFrame& last, StageTimes* times);
  bool UpdateView(const Rigid3d& world_from_predicted, bool has_intensities);
  Tracked TrackFromPrediction(const PreparedFrame& frame, StageTimes* times);
  bool IsFar(const PreparedFrame& frame, const Rigid3d& world_from_camera) const;
  Tracked SearchFor(const PreparedFrame& frame, Tracked tracked);
  std::optional<Tracked> ConfirmProposal(const PreparedFrame& frame, const Tracked& tracked);
  std::optional<Tracked> FindAgain(const PreparedFrame& frame);
  std::optional<Tracked> Relocalize(const PreparedFrame& frame);
  std::optional<Tracked> Confirm(const PreparedFrame& frame, const Rigid3d& world_from_found);
  bool IsNewMapDue(const PreparedFrame& frame) const;
  std::optional<ConfirmedFrame> AddConfirmed();
  bool IsHeldOut(const Tracked& tracked) const;
  std::optional<FusionReport> FuseInTurn(const PreparedFrame& frame, const Tracked& tracked,
                                         StageTimes* times);
  bool tracks_frame_to_frame() const { return options_.tracking == "frame_to_frame"; }

  DepthSensor sensor_;  // as given
  SlamOptions options_;
  Tracker tracker_;
  Mapper mapper_;
  std::unique_ptr<Backend> backend_;  // null without loops and calibration
  bool is_frozen_ = false;            // the camera is localised in a map that stays as it is
  RgbdFrame seen_;                    // the frame at work, if it is not taken as it comes
  RgbdFrame seen_rest_, rest_;        // the same, and the frame as given, without what moves
  RgbdFrame proposed_;   // the last frame that was proposed, as given without what moves
  int frame_count_ = 0;  // the frame at work included
  std::function<void(const FramePose&)> on_pose_;
  std::function<void(const LostFrame&)> on_lost_;
};

// A camera that was calibrated stays so, whatever the options say.
Slam::Pipeline::Pipeline(const DepthSensor& sensor, SlamOptions options, SlamState state,
                         StateUse use)
    : Pipeline(
          sensor,
          [&] {
            options.calibration.enabled |= state.calibration.has_value();
            return options;
          }(),
          state.frames.empty() ? Rigid3d() : state.frames.back().world_from_camera) {
  if (!options.loops.enabled) {
    throw InputError("loops.enabled is false, must be true to go on from a state");
  }
  if (tracks_frame_to_frame()) {
    throw InputError(
        "tracking is 'frame_to_frame', must be 'frame_to_model' to go on from a state");
  }
  if (state.keyframes.empty()) throw InputError("the state has no keyframe, must have one");
  is_frozen_ = use == StateUse::kLocalize;
  DepthSensor found = sensor;
  if (state.calibration) {
    found.camera = state.calibration->camera;
    found.readout_s = state.calibration->readout_s;
  }
  tracker_.GoOnAfter(state.frames.back().stamp_s);
  std::vector<int> fused;
  if (!is_frozen_) fused = FusedFrames(state.frames, options_.map_period);
  mapper_.GoOnFrom(std::move(state.map), fused, found);
  backend_->GoOnFrom(&state, use);
}

FrameReport Slam::Pipeline::Process(const RgbdFrame& frame,
                                    const std::optional<Rigid3d>& given_pose) {
  CHECK_EQ(frame.depth_m.width(), sensor_.camera.width);
  CHECK_EQ(frame.depth_m.height(), sensor_.camera.height);
  CHECK(frame.color.empty() || frame.color.size() == frame.depth_m.size());
  StageTimes times;
  ++frame_count_;
  if (backend_) CorrectWorld(frame.index, &times);
  if (tracker_.Repeats(frame) && !given_pose) {
    const Tracked repeated = Repeat(frame);
    TellPose(frame, repeated);
    return Report(frame, repeated, {}, times);
  }
  if (given_pose && backend_) backend_->EndCalibration();
  const CameraMotion motion = given_pose ? tracker_.MotionTo(frame.stamp_s, Given(*given_pose))
                                         : tracker_.expected_motion();
  PreparedFrame whole = Prepare(frame, motion, &times);
  const Tracked tracked =
      given_pose ? Given(*given_pose) : tracker_.Checked(whole, Track(whole, &times));
  TellPose(frame, tracked);
  if (tracker_.has_proposal()) proposed_ = AtRest(frame, tracked.moving);
  if (!tracked.is_held()) {
    tracker_.Lose();
    return Report(frame, tracked, {}, times);
  }
  const std::optional<ConfirmedFrame> confirmed = AddConfirmed();
  tracker_.Remember(whole, tracked);
  PreparedFrame prepared = AtRest(std::move(whole), tracked.moving);
  if (backend_ && !is_frozen_) {
    backend_->AddFrame(AtRest(frame, tracked.moving), tracked.world_from_camera, tracked.icp,
                       prepared.view.pyramid);
  }
  const bool is_held_out = IsHeldOut(tracked);
  std::optional<FusionReport> fused;
  if (is_held_out || is_frozen_) {
    mapper_.Skip();
  } else {
    fused = FuseInTurn(prepared, tracked, &times);
  }
  tracker_.Keep(std::move(prepared), tracked);
  if (!given_pose) DrawForNext(frame, &times);
  FrameReport report = Report(frame, tracked, fused, times);
  report.is_held_out = is_held_out;
  report.confirmed = confirmed;
  return report;
}

// The frame before, once this one agrees with it. It is not fused: this one is.
std::optional<ConfirmedFrame> Slam::Pipeline::AddConfirmed() {
  const Proposal* confirmed = tracker_.confirmed();
  if (!confirmed) return std::nullopt;
  const auto& [view, world_from_view, grey] = confirmed->view;
  if (backend_ && !is_frozen_) {
    backend_->AddFrame(proposed_, world_from_view, confirmed->tracked.icp, view.pyramid);
  }
  return ConfirmedFrame{proposed_.index, proposed_.stamp_s, world_from_view};
}

// Without a frame that begins a map there would be none.
bool Slam::Pipeline::IsHeldOut(const Tracked& tracked) const {
  const bool begins_map = !tracker_.has_started() || tracked.state == FrameState::kNewMap;
  return options_.hold_out > 0 && !begins_map && frame_count_ % options_.hold_out == 0;
}

void Slam::Pipeline::MakeBackend(LoopFinder finder) {
  backend_ = std::make_unique<Backend>(sensor_, options_.preprocess, options_.loops,
                                       options_.calibration, std::move(finder));
}

// By what has been found of loops and the camera, if it takes effect with this frame.
void Slam::Pipeline::CorrectWorld(int frame_index, StageTimes* times) {
  const StageTimer timer("correct", frame_index, &times->correct_ms);
  for (const WorldCorrection& correction : backend_->BeginFrame()) Correct(correction, frame_index);
}

// The map moves as the camera does, so that tracking goes on as if nothing had been.
void Slam::Pipeline::Correct(const WorldCorrection& correction, int frame_index) {
  if (correction.moves) tracker_.Move(correction.new_from_old_now);
  mapper_.Correct(correction, frame_index);
}

void Slam::Pipeline::TellPose(const RgbdFrame& frame, const Tracked& tracked) const {
  if (on_pose_) on_pose_({frame.index, frame.stamp_s, tracked.state, tracked.world_from_camera});
}

Tracked Slam::Pipeline::Repeat(const RgbdFrame& frame) {
  Tracked tracked = tracker_.Repeat();
  if (backend_ && !is_frozen_ && tracked.is_held())
    backend_->AddFrozenFrame(frame.index, frame.stamp_s);
  return tracked;
}

PreparedFrame Slam::Pipeline::Prepare(const RgbdFrame& frame, const CameraMotion& motion,
                                      StageTimes* times) {
  const StageTimer timer("preprocess", frame.index, &times->preprocess_ms);
  const RgbdFrame& seen = AsSeen(frame, motion);
  FramePyramid pyramid = PreprocessDepth(seen.depth_m, mapper_.sensor(), options_.preprocess);
  if (tracker_.needs_intensities()) AddIntensity(seen.color, &pyramid);
  return {seen, {std::move(pyramid), seen.color}, motion};
}

// The frame by the depth that calibration has found, in the middle of its readout, with its colours
// as of the moment that was found. They stay where they are: they are looked up by the motion of
// their rows.
const RgbdFrame& Slam::Pipeline::AsSeen(const RgbdFrame& frame, const CameraMotion& motion) {
  const bool is_recalibrated = backend_ && backend_->is_recalibrated();
  const double color_latency_s = backend_ ? backend_->color_latency_s() : 0;
  const bool moves = mapper_.sensor().readout_s > 0 && !motion.IsZero();
  if (!is_recalibrated && !moves && color_latency_s == 0) return frame;
  seen_ = {frame.index, frame.stamp_s, frame.color_stamp_s - color_latency_s, frame.depth_m, {}};
  if (is_recalibrated) {
    const DepthCalibration& calibration = *backend_->calibration();
    CorrectDepth(calibration.camera, calibration.field, &seen_.depth_m);
  }
  if (moves) seen_ = AtMiddleOfReadout(seen_, mapper_.sensor(), motion);
  seen_.color = frame.color;
  return seen_;
}

// The frame as given without what moves.
const RgbdFrame& Slam::Pipeline::AtRest(const RgbdFrame& frame, const CellMask& moving) {
  if (moving.empty()) return frame;
  rest_ = frame;
  rest_.depth_m = Without(std::move(rest_.depth_m), moving);
  return rest_;
}

PreparedFrame Slam::Pipeline::AtRest(PreparedFrame frame, const CellMask& moving) {
  if (moving.empty()) return frame;
  seen_rest_ = frame.images;
  seen_rest_.depth_m = Without(std::move(seen_rest_.depth_m), moving);
  frame.view.pyramid = Without(std::move(frame.view.pyramid), moving);
  return {seen_rest_, std::move(frame.view), frame.motion};
}

// Where all that was known of the camera has failed for long, a new map begins.
Tracked Slam::Pipeline::Track(const PreparedFrame& frame, StageTimes* times) {
  if (!tracker_.has_started()) return tracker_.Start(frame);
  Tracked tracked = TrackFromPrediction(frame, times);
  if (!tracked.is_held() && !tracker_.has_proposal() && IsNewMapDue(frame)) {
    tracked.state = FrameState::kNewMap;
    tracked.moving = {};
    tracked.world_from_camera = backend_->BeginSubmap(tracker_.last().world_from_view);
  }
  return tracked;
}

// What the next frame is expected to see, if it has colours like the last, so that its pose need
// not wait for the drawing.
void Slam::Pipeline::DrawForNext(const RgbdFrame& last, StageTimes* times) {
  const std::optional<Rigid3d> world_from_next = tracker_.PredictNext();
  if (tracks_frame_to_frame() || !world_from_next) return;
  const StageTimer timer("draw_ahead", last.index, &times->predict_ms);
  UpdateView(*world_from_next, tracker_.needs_intensities() && !last.color.empty());
}

// Intensities are compared more finely than surfaces: with views that frames share the largest
// error before textured walls is twice as large.
bool Slam::Pipeline::UpdateView(const Rigid3d& world_from_predicted, bool has_intensities) {
  return mapper_.UpdateView(world_from_predicted, tracker_.needs_all() || has_intensities,
                            has_intensities);
}

// Registers the frame from where the camera is expected, to what is expected to be seen there;
// where that fails or is in doubt, looks for it from afar.
Tracked Slam::Pipeline::TrackFromPrediction(const PreparedFrame& frame, StageTimes* times) {
  const int index = frame.images.index;
  Rigid3d world_from_predicted;
  bool has_own_view = tracks_frame_to_frame();
  {
    const StageTimer timer("predict", index, &times->predict_ms);
    world_from_predicted = tracker_.Predict(frame);
    if (!has_own_view) {
      has_own_view = UpdateView(world_from_predicted, HasIntensities(frame));
    }
  }
  const ReferenceView& reference = tracks_frame_to_frame() ? tracker_.last() : mapper_.view();
  const StageTimer timer("track", index, &times->track_ms);
  Tracked tracked = tracker_.Track(frame, reference, world_from_predicted);
  const bool is_far = tracker_.doubts() && (IsFar(frame, world_from_predicted) ||
                                            IsFar(frame, tracked.world_from_camera));
  if (std::optional<Tracked> confirmed = ConfirmProposal(frame, tracked)) {
    tracked = *std::move(confirmed);
  } else if (is_far || tracker_.IsDoubtful(tracked)) {
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
        tracker_.PoseByItsMotion(frame, mapper_.sensor().readout_s, tracked);
  }
  return tracked;
}

// A doubtful frame from afar. Where another run has ended the camera need not be. What is found
// without being sure is proposed, and lost.
Tracked Slam::Pipeline::SearchFor(const PreparedFrame& frame, Tracked tracked) {
  if (!tracker_.MayFollow(frame)) tracked.state = FrameState::kLost;
  tracked = tracker_.Better(std::move(tracked), FindAgain(frame));
  if (!tracked.is_held()) {
    if (std::optional<Tracked> found = Relocalize(frame)) tracked = *std::move(found);
  }
  if (tracked.is_held() && tracker_.NeedsConfirmation(frame, tracked)) {
    tracker_.Propose(frame, tracked);
    tracked.state = FrameState::kLost;
  } else if (tracked.is_held() && tracked.keyframe >= 0) {
    backend_->AfterRelocalization(tracked.keyframe);
  }
  return tracked;
}

// A frame that was tracked from where the one before was found, if that was not sure.
std::optional<Tracked> Slam::Pipeline::ConfirmProposal(const PreparedFrame& frame,
                                                       const Tracked& tracked) {
  if (!tracker_.has_proposal()) return std::nullopt;
  std::optional<Tracked> confirmed = tracker_.ConfirmProposal(frame, tracked);
  if (confirmed && confirmed->keyframe >= 0) backend_->AfterRelocalization(confirmed->keyframe);
  return confirmed;
}

// Farther from the last frame than tracking surely follows.
bool Slam::Pipeline::IsFar(const PreparedFrame& frame, const Rigid3d& world_from_camera) const {
  const Rigid3d motion = tracker_.last().world_from_view.Inverse() * world_from_camera;
  return ImageShift(motion, frame.view.pyramid.levels.back()) > options_.max_view_shift;
}

// From the last good frame as far as the views tell, and from there against the map.
std::optional<Tracked> Slam::Pipeline::FindAgain(const PreparedFrame& frame) {
  const std::optional<Rigid3d> world_from_found = tracker_.FindFromLast(frame);
  return world_from_found ? Confirm(frame, *world_from_found) : std::nullopt;
}

// By a keyframe that shows the same place, and from there against the map.
std::optional<Tracked> Slam::Pipeline::Relocalize(const PreparedFrame& frame) {
  if (!options_.loops.enabled || tracker_.lost_count() % kRelocalizeStride != 0)
    return std::nullopt;
  if (!tracker_.HasEnoughDepth(frame)) return std::nullopt;
  const Relocalization found = backend_->Find(frame.view);
  if (!found.found()) return std::nullopt;
  if (!is_frozen_) {
    mapper_.WakeAround(backend_->FrameOfKeyframe(found.keyframe), frame.images.index);
  }
  std::optional<Tracked> tracked = Confirm(frame, found.world_from_camera);
  if (!tracked) return std::nullopt;
  tracked->state = FrameState::kRelocalized;
  tracked->keyframe = found.keyframe;
  return tracked;
}

std::optional<Tracked> Slam::Pipeline::Confirm(const PreparedFrame& frame,
                                               const Rigid3d& world_from_found) {
  if (tracks_frame_to_frame()) return tracker_.Confirm(frame, tracker_.last(), world_from_found);
  return tracker_.Confirm(frame, mapper_.Draw(world_from_found, HasIntensities(frame)),
                          world_from_found);
}

bool Slam::Pipeline::IsNewMapDue(const PreparedFrame& frame) const {
  const int after = options_.loops.new_map_after;
  return options_.loops.enabled && !is_frozen_ && after > 0 && tracker_.lost_count() + 1 >= after &&
         tracker_.HasEnoughDepth(frame);
}

// In its turn, and at once where the map may not have been seen from.
std::optional<FusionReport> Slam::Pipeline::FuseInTurn(const PreparedFrame& frame,
                                                       const Tracked& tracked, StageTimes* times) {
  const bool must = tracked.state == FrameState::kFirst || tracked.state == FrameState::kGiven ||
                    tracked.found_again || tracker_.needs_all();
  if (!must && !mapper_.IsTurnToFuse(frame, tracked.world_from_camera)) {
    mapper_.Skip();
    return std::nullopt;
  }
  const StageTimer timer("fuse", frame.images.index, &times->fuse_ms);
  return mapper_.Fuse(frame, tracked.world_from_camera,
                      tracker_.MotionTo(frame.images.stamp_s, tracked));
}

void Slam::Pipeline::UseLoopFinder(LoopFinder finder) {
  CHECK(options_.loops.enabled && backend_->frames().empty());
  MakeBackend(std::move(finder));
}

void Slam::Pipeline::Finish() {
  if (!backend_ || backend_->frames().empty() || is_frozen_) return;
  for (const WorldCorrection& correction : backend_->Finish()) {
    Correct(correction, backend_->frames().back().index);
  }
}

Slam::Slam(const DepthSensor& sensor, const SlamOptions& options,
           const Rigid3d& world_from_first_camera)
    : pipeline_(std::make_unique<Pipeline>(sensor, options, world_from_first_camera)) {}

Slam::Slam(const DepthSensor& sensor, const SlamOptions& options, SlamState state, StateUse use)
    : pipeline_(std::make_unique<Pipeline>(sensor, options, std::move(state), use)) {}

Slam::~Slam() = default;

FrameReport Slam::Process(const RgbdFrame& frame) {
  return pipeline_->Process(frame, std::nullopt);
}

FrameReport Slam::ProcessAt(const RgbdFrame& frame, const Rigid3d& world_from_camera) {
  return pipeline_->Process(frame, world_from_camera);
}

void Slam::OnPose(std::function<void(const FramePose&)> call) {
  pipeline_->on_pose() = std::move(call);
}

void Slam::OnLostFrame(std::function<void(const LostFrame&)> call) {
  pipeline_->on_lost() = std::move(call);
}

void Slam::UseLoopFinder(LoopFinder finder) { pipeline_->UseLoopFinder(std::move(finder)); }

void Slam::OnKeyframe(KeyframeCall call) { pipeline_->OnKeyframe(std::move(call)); }

void Slam::Finish() { pipeline_->Finish(); }

const SurfelMap& Slam::map() const { return pipeline_->mapper().map(); }

std::size_t Slam::merged_doubles() const { return pipeline_->mapper().merged_doubles(); }

int Slam::corrections_of_map() const { return pipeline_->mapper().corrections(); }

const DepthSensor& Slam::sensor() const { return pipeline_->mapper().sensor(); }

const Backend* Slam::backend() const { return pipeline_->backend(); }

}  // namespace surfit
