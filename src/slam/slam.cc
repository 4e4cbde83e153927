#include "surfit/slam/slam.h"

#include <glog/logging.h>

#include <utility>
#include <vector>

#include "core/trace.h"
#include "slam/frame_report.h"
#include "slam/mapper.h"
#include "slam/pose_finder.h"
#include "slam/prepared_frame.h"
#include "slam/tracker.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/slam/slam_state.h"

namespace surfit {
namespace {

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

Tracked Given(const Rigid3d& world_from_camera) {
  Tracked tracked;
  tracked.state = FrameState::kGiven;
  tracked.world_from_camera = world_from_camera;
  return tracked;
}

}  // namespace

// The finder finds poses by the tracker, which follows the camera, and by the map, which the mapper
// keeps; the backend closes loops.
class Slam::Pipeline {
 public:
  Pipeline(const DepthSensor& sensor, const SlamOptions& options,
           const Rigid3d& world_from_first_camera)
      : Pipeline(sensor, options, world_from_first_camera, StateUse::kContinue) {}

  Pipeline(const DepthSensor& sensor, SlamOptions options, SlamState state, StateUse use);

  FrameReport Process(const RgbdFrame& frame, const std::optional<Rigid3d>& given_pose);
  void UseLoopFinder(LoopFinder finder);
  void Finish();

  std::function<void(const FramePose&)>& on_pose() { return on_pose_; }
  PoseFinder& finder() { return finder_; }
  const Mapper& mapper() const { return mapper_; }
  void SetMapPeriod(int frames) { mapper_.SetPeriod(frames); }
  const Backend* backend() const { return backend_.get(); }
  void OnKeyframe(KeyframeCall call) { backend_->OnKeyframe(std::move(call)); }

 private:
  Pipeline(const DepthSensor& sensor, const SlamOptions& options,
           const Rigid3d& world_from_first_camera, StateUse use);
  void MakeBackend(LoopFinder finder);
  void CorrectWorld(int frame_index, StageTimes* times);
  void Correct(const WorldCorrection& correction, int frame_index);
  void TellPose(const RgbdFrame& frame, const Tracked& tracked) const;
  Tracked Repeat(const RgbdFrame& frame);
  PreparedFrame Prepare(const RgbdFrame& frame, const CameraMotion& motion, StageTimes* times);
  std::optional<ConfirmedFrame> AddConfirmed();
  bool IsHeldOut(const Tracked& tracked) const;
  std::optional<FusionReport> FuseInTurn(const PreparedFrame& frame, const Tracked& tracked,
                                         StageTimes* times);
  // Where frames are kept: null where there is no backend, or it stays as it is.
  Backend* keeper() const { return is_frozen_ ? nullptr : backend_.get(); }

  DepthSensor sensor_;  // as given
  SlamOptions options_;
  const bool is_frozen_;  // the camera is localised in a map that stays as it is
  Tracker tracker_;
  Mapper mapper_;
  FrameMaker frame_maker_;
  PoseFinder finder_;
  std::unique_ptr<Backend> backend_;  // null without loops and calibration
  RgbdFrame proposed_;   // the last frame that was proposed, as given without what moves
  int frame_count_ = 0;  // the frame at work included
  std::function<void(const FramePose&)> on_pose_;
};

Slam::Pipeline::Pipeline(const DepthSensor& sensor, const SlamOptions& options,
                         const Rigid3d& world_from_first_camera, StateUse use)
    : sensor_(sensor),
      options_(Validated(options)),
      is_frozen_(use == StateUse::kLocalize),
      tracker_(options_, world_from_first_camera),
      mapper_(sensor, options_),
      frame_maker_(options_.preprocess),
      finder_(options_, !is_frozen_, &tracker_, &mapper_) {
  sensor.Validate();
  if (options.loops.enabled || options.calibration.enabled) MakeBackend({});
}

// A camera that was calibrated stays so, whatever the options say.
Slam::Pipeline::Pipeline(const DepthSensor& sensor, SlamOptions options, SlamState state,
                         StateUse use)
    : Pipeline(
          sensor,
          [&] {
            options.calibration.enabled |= state.calibration.has_value();
            return options;
          }(),
          state.frames.empty() ? Rigid3d() : state.frames.back().world_from_camera, use) {
  if (!options.loops.enabled) {
    throw InputError("loops.enabled is false, must be true to go on from a state");
  }
  if (options_.tracking == "frame_to_frame") {
    throw InputError(
        "tracking is 'frame_to_frame', must be 'frame_to_model' to go on from a state");
  }
  if (state.keyframes.empty()) throw InputError("the state has no keyframe, must have one");
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
      given_pose ? Given(*given_pose) : tracker_.Checked(whole, finder_.Find(whole, &times));
  TellPose(frame, tracked);
  if (tracker_.has_proposal()) proposed_ = frame_maker_.AtRest(frame, tracked.moving);
  if (!tracked.is_held()) {
    tracker_.Lose();
    return Report(frame, tracked, {}, times);
  }
  const std::optional<ConfirmedFrame> confirmed = AddConfirmed();
  tracker_.Remember(whole, tracked);
  PreparedFrame prepared = frame_maker_.AtRest(std::move(whole), tracked.moving);
  if (Backend* const backend = keeper()) {
    backend->AddFrame(frame_maker_.AtRest(frame, tracked.moving), tracked.world_from_camera,
                      tracked.icp, prepared.view.pyramid);
  }
  const bool is_held_out = IsHeldOut(tracked);
  std::optional<FusionReport> fused;
  if (is_held_out || is_frozen_) {
    mapper_.Skip();
  } else {
    fused = FuseInTurn(prepared, tracked, &times);
  }
  tracker_.Keep(std::move(prepared), tracked);
  if (!given_pose) finder_.DrawForNext(frame, &times);
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
  if (Backend* const backend = keeper()) {
    backend->AddFrame(proposed_, world_from_view, confirmed->tracked.icp, view.pyramid);
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
                                       options_.calibration, std::move(finder), options_.real_time);
  finder_.UseBackend(backend_.get());
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
  Backend* const backend = keeper();
  if (backend && tracked.is_held()) backend->AddFrozenFrame(frame.index, frame.stamp_s);
  return tracked;
}

PreparedFrame Slam::Pipeline::Prepare(const RgbdFrame& frame, const CameraMotion& motion,
                                      StageTimes* times) {
  const StageTimer timer("preprocess", frame.index, &times->preprocess_ms);
  return frame_maker_.Prepare(frame, motion, mapper_.sensor(), backend_.get(),
                              tracker_.needs_intensities());
}

// In its turn, and at once where the map may not have been seen from.
std::optional<FusionReport> Slam::Pipeline::FuseInTurn(const PreparedFrame& frame,
                                                       const Tracked& tracked, StageTimes* times) {
  const bool must = tracked.state == FrameState::kFirst || tracked.state == FrameState::kGiven ||
                    tracked.found_again || tracked.is_by_newest ||
                    (tracker_.needs_all() && !mapper_.is_hurried());
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
  Backend* const backend = keeper();
  if (!backend || backend->frames().empty()) return;
  for (const WorldCorrection& correction : backend->Finish()) {
    Correct(correction, backend->frames().back().index);
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
  pipeline_->finder().OnLostFrame(std::move(call));
}

void Slam::UseLoopFinder(LoopFinder finder) { pipeline_->UseLoopFinder(std::move(finder)); }

void Slam::OnKeyframe(KeyframeCall call) { pipeline_->OnKeyframe(std::move(call)); }

void Slam::SetMapPeriod(int frames) {
  if (frames < 1) throw InputError(Concat("frames is ", frames, ", must be at least 1"));
  pipeline_->SetMapPeriod(frames);
}

void Slam::Finish() { pipeline_->Finish(); }

const SurfelMap& Slam::map() const { return pipeline_->mapper().map(); }

std::size_t Slam::merged_doubles() const { return pipeline_->mapper().merged_doubles(); }

int Slam::corrections_of_map() const { return pipeline_->mapper().corrections(); }

const DepthSensor& Slam::sensor() const { return pipeline_->mapper().sensor(); }

const Backend* Slam::backend() const { return pipeline_->backend(); }

}  // namespace surfit
