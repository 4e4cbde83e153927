#include "surfit/slam/slam.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "core/trace.h"
#include "slam/mapper.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "tracking/tracker.h"

namespace surfit {
namespace {

// Copies LoopOptions::active_frames to the fusion options, which have their own field.
SlamOptions Validated(SlamOptions options) {
  Validate(options);
  int& active_frames = options.fusion.active_frames;
  if (options.loops.enabled && active_frames == 0) active_frames = options.loops.active_frames;
  return options;
}

SlamOptions WithCalibrationOf(const SlamState& state, SlamOptions options) {
  options.calibration.enabled |= state.calibration.has_value();
  return options;
}

// Approximate indices of fused frames: every `period`-th frame up to the last frame.
std::vector<int> FusedFrames(const std::vector<PosedFrame>& frames, int period) {
  std::vector<int> fused;
  for (std::size_t i = (frames.size() - 1) % period; i < frames.size(); i += period) {
    fused.push_back(frames[i].index);
  }
  return fused;
}

FrameReport ReportOf(const RgbdFrame& frame, const Tracked& tracked) {
  FrameReport report;
  report.index = frame.index;
  report.stamp_s = frame.stamp_s;
  report.state = tracked.state;
  report.world_from_camera = tracked.world_from_camera;
  report.found_by_search = tracked.found_by_search;
  report.has_own_view = tracked.has_own_view;
  report.moving_ratio = tracked.moving_ratio;
  report.has_two_motions = tracked.has_two_motions;
  report.moving = tracked.moving;
  report.icp = tracked.icp;
  return report;
}

class BackendRelocalizer : public Relocalizer {
 public:
  BackendRelocalizer(Backend* backend, int new_map_after)
      : backend_(backend), new_map_after_(new_map_after) {}

  std::optional<KeyframePose> Find(const ColoredView& view, int rank) override {
    const Relocalization found = backend_->Find(view, rank);
    if (!found.found()) return std::nullopt;
    const KeyframeLink& link = backend_->poses().keyframes()[found.keyframe];
    return KeyframePose{found.keyframe, link.frame, link.submap, found.world_from_camera};
  }

  std::optional<Rigid3d> RegisterTo(const ColoredView& earlier, const ColoredView& view) override {
    const GlobalRegistrationResult found = backend_->RegisterTo(earlier, view);
    if (!found.accepted()) return std::nullopt;
    return found.target_from_source;
  }

  std::optional<int> BeginSubmap(int lost_frames) override {
    if (new_map_after_ == 0 || lost_frames < new_map_after_) return std::nullopt;
    return backend_->BeginSubmap();
  }

 private:
  Backend* backend_;
  int new_map_after_;
};

}  // namespace

Slam::Slam(const DepthSensor& sensor, const SlamOptions& options,
           const Rigid3d& world_from_first_camera)
    : Slam(sensor, options, world_from_first_camera, StateUse::kContinue) {}

Slam::Slam(const DepthSensor& sensor, const SlamOptions& options,
           const Rigid3d& world_from_first_camera, StateUse use)
    : sensor_(sensor),
      options_(Validated(options)),
      use_(use),
      preprocessor_(std::make_unique<FramePreprocessor>(options_.preprocess)),
      mapper_(std::make_unique<Mapper>(sensor, options_, use)),
      tracker_(std::make_unique<Tracker>(options_, world_from_first_camera, mapper_.get())) {
  sensor.Validate();
  if (options.loops.HasViews() || options.calibration.enabled) MakeBackend({});
}

Slam::Slam(const DepthSensor& sensor, const SlamOptions& options, SlamState state, StateUse use)
    : Slam(sensor, WithCalibrationOf(state, options),
           state.frames.empty() ? Rigid3d() : state.frames.back().world_from_camera, use) {
  if (!options.loops.HasViews()) {
    throw InputError(
        "loops.enabled and loops.relocalization are false, one must be true to go on from a state");
  }
  if (options_.IsFrameToFrame()) {
    throw InputError(
        "tracking is 'frame_to_frame', must be 'frame_to_model' to go on from a state");
  }
  if (state.keyframes.empty()) throw InputError("the state has no keyframe, must have one");
  tracker_->StartInGivenMap(state.frames.back().stamp_s);
  std::vector<int> fused;
  if (use == StateUse::kContinue) fused = FusedFrames(state.frames, options_.map_period);
  int submaps = 0;
  for (const KeyframeLink& link : state.keyframes) submaps = std::max(submaps, link.submap + 1);
  tracker_->UseSubmap(state.keyframes.back().submap);
  mapper_->ContinueFrom(std::move(state.map), fused, submaps);
  backend_->ContinueFrom(&state, use);
}

Slam::~Slam() = default;

void Slam::MakeBackend(LoopFinder finder) {
  backend_ = std::make_unique<Backend>(sensor_, options_.preprocess, options_.loops,
                                       options_.calibration, std::move(finder), options_.real_time);
  backend_->OnKeyframe(on_keyframe_);
  mapper_->UseCalibration(backend_->calibration());
  UsePriorEdges();
  if (!options_.loops.HasViews()) return;
  relocalizer_ = std::make_unique<BackendRelocalizer>(
      backend_.get(), use_ == StateUse::kContinue ? options_.loops.new_map_after : 0);
  tracker_->UseRelocalizer(relocalizer_.get());
}

static void RequireImagesOf(const PinholeCamera& camera, const RgbdFrame& frame) {
  ThrowIf(frame.depth_m.width() != camera.width || frame.depth_m.height() != camera.height,
          "frame ", frame.index, ": the depth image has ", frame.depth_m.width(), " x ",
          frame.depth_m.height(), " pixels, must have ", camera.width, " x ", camera.height,
          " like the sensor");
  ThrowIf(!frame.color.empty() &&
              (frame.color.width() != camera.width || frame.color.height() != camera.height),
          "frame ", frame.index, ": the colour image has ", frame.color.width(), " x ",
          frame.color.height(), " pixels, must have ", camera.width, " x ", camera.height,
          " like depth");
}

// Stages of a frame and their classes:
//   correct    apply finished loop closures and calibrations   Backend, Mapper
//   prepare    depth image to surfaces                         FramePreprocessor
//   predict    predicted pose, model view at this pose         Tracker, Mapper
//   track      register, search, validate                      Tracker
//   keyframe   store the pose, choose keyframes                Backend, PoseStore
//   fuse       update the surfels                              Mapper, Fusion
//   report     outcome and times                               FrameReport
FrameReport Slam::Process(const RgbdFrame& frame) {
  RequireImagesOf(sensor_.camera, frame);
  if (!frame.color.empty() && !tracker_->AcceptsColor(frame)) {
    RgbdFrame depth_alone = frame;
    depth_alone.color = {};
    return Process(depth_alone);
  }
  StageTimes times;
  Correct(frame, &times);
  if (tracker_->IsDuplicate(frame)) return ReportDuplicate(frame, times);
  PreprocessedFrame prepared = Preprocess(frame, tracker_->ExpectedMotion(frame.stamp_s), &times);
  const bool is_first = !tracker_->state().HasStarted();
  Tracked tracked = is_first ? tracker_->TrackFirst(prepared)
                             : Track(prepared, Predict(prepared, &times), &times);
  FrameReport report = Integrate(std::move(prepared), std::move(tracked), &times);
  if (report.HasPose() && !mapper_->has_longer_period()) PredictAhead(frame, &times);
  report.times = times;
  return report;
}

FrameReport Slam::ProcessAt(const RgbdFrame& frame, const Rigid3d& world_from_camera) {
  RequireImagesOf(sensor_.camera, frame);
  StageTimes times;
  Correct(frame, &times);
  tracker_->IsDuplicate(frame);
  if (backend_) backend_->EndCalibration();
  PreprocessedFrame prepared =
      Preprocess(frame, tracker_->MotionTo(frame.stamp_s, world_from_camera), &times);
  Tracked tracked = tracker_->TrackGiven(prepared, world_from_camera);
  FrameReport report = Integrate(std::move(prepared), std::move(tracked), &times);
  report.times = times;
  return report;
}

void Slam::Correct(const RgbdFrame& frame, StageTimes* times) {
  ++frame_count_;
  if (!backend_) return;
  const StageTimer timer("correct", frame.index, &times->correct_ms);
  for (const WorldCorrection& correction : backend_->BeginFrame()) Apply(correction, frame.index);
}

// Map and camera move equally, so tracking continues without a jump.
void Slam::Apply(const WorldCorrection& correction, int frame_index) {
  if (correction.moves) {
    tracker_->Move(correction.new_from_old_now,
                   [&](int frame) { return correction.corrections.At(frame); });
  }
  mapper_->Correct(correction, frame_index);
}

PreprocessedFrame Slam::Preprocess(const RgbdFrame& frame, const CameraMotion& motion,
                                   StageTimes* times) {
  const StageTimer timer("preprocess", frame.index, &times->preprocess_ms);
  SensorCorrection correction;
  if (backend_ && backend_->is_recalibrated()) correction.calibration = backend_->calibration();
  if (backend_) correction.color_latency_s = backend_->color_latency_s();
  return preprocessor_->Preprocess(frame, motion, mapper_->sensor(), correction,
                                   tracker_->NeedsIntensities());
}

Prediction Slam::Predict(const PreprocessedFrame& frame, StageTimes* times) {
  const StageTimer timer("predict", frame.images.index, &times->predict_ms);
  return tracker_->Predict(frame);
}

void Slam::PredictAhead(const RgbdFrame& frame, StageTimes* times) {
  const StageTimer timer("draw_ahead", frame.index, &times->predict_ms);
  tracker_->PredictAhead(!frame.color.empty());
}

Tracked Slam::Track(const PreprocessedFrame& frame, const Prediction& prediction,
                    StageTimes* times) {
  const StageTimer timer("track", frame.images.index, &times->track_ms);
  Tracked tracked = tracker_->Track(frame, prediction);
  if (tracked.keyframe >= 0) backend_->AfterRelocalization(tracked.keyframe);
  return tracked;
}

FrameReport Slam::ReportDuplicate(const RgbdFrame& frame, const StageTimes& times) {
  const Tracked tracked = tracker_->Repeat();
  if (!tracked.has_pose()) NoteLost(frame);
  if (keeper() && tracked.has_pose()) keeper()->AddDuplicateFrame(frame.index, frame.stamp_s);
  FrameReport report = ReportOf(frame, tracked);
  if (on_pose_) on_pose_(report);
  report.times = times;
  return report;
}

FrameReport Slam::Integrate(PreprocessedFrame frame, Tracked tracked, StageTimes* times) {
  FrameReport report = ReportOf(frame.measured, tracked);
  if (on_pose_) on_pose_(report);
  if (!tracked.has_pose()) {
    NoteLost(frame.measured);
    tracker_->Update(std::move(frame), std::move(tracked));
    return report;
  }
  report.confirmed = AddConfirmed(tracked);
  const std::size_t keyframes = keeper() ? keeper()->poses().keyframes().size() : 0;
  if (keyframes > 0) SetCovariance(tracked, &report);
  PreprocessedFrame rest = preprocessor_->WithoutMovingObjects(std::move(frame), tracked.moving);
  if (keeper()) {
    keeper()->AddFrame(rest.measured, tracked.world_from_camera, tracked.icp, rest.view.pyramid);
  }
  const bool is_keyframe = keeper() && keeper()->poses().keyframes().size() > keyframes;
  report.is_held_out = IsHeldOut(tracked);
  Fuse(rest, tracked, &report, times);
  UpdateCovarianceOfMap(tracked, is_keyframe, report);
  tracker_->Update(std::move(rest), std::move(tracked));
  return report;
}

// With the errors f of this frame and k of the keyframe as right perturbations of their poses, the
// left perturbation of the relative pose is Ad f - k. Both are independent: each frame has noise of
// its own.
void Slam::SetCovariance(const Tracked& tracked, FrameReport* report) const {
  if (tracked.found_by_search || tracked.state == FrameState::kNewMap) return;
  const PoseStore& poses = keeper()->poses();
  const PosedFrame& keyframe = poses.FrameOf(static_cast<int>(poses.keyframes().size()) - 1);
  report->keyframe = keyframe.index;
  report->keyframe_from_camera = keyframe.world_from_camera.Inverse() * tracked.world_from_camera;
  if (!tracked.registered_covariance || !covariance_of_map_) return;
  const Matrix6d transform = IncrementTransform(report->keyframe_from_camera);
  report->covariance =
      *covariance_of_map_ + transform * *tracked.registered_covariance * transform.transpose();
}

// The error of the map is a random walk: the next view shows mainly the last fused frames.
void Slam::UpdateCovarianceOfMap(const Tracked& tracked, bool is_keyframe,
                                 const FrameReport& report) {
  if (is_keyframe) {
    covariance_of_map_ = tracked.registered_covariance;
    if (tracked.state == FrameState::kFirst || tracked.state == FrameState::kNewMap) {
      covariance_of_map_ = Matrix6d(Matrix6d::Zero());
    }
  } else if (report.is_fused) {
    covariance_of_map_ = report.covariance;
  }
}

// Adds the tentative frame whose pose is now confirmed. This frame is not fused.
std::optional<PosedFrame> Slam::AddConfirmed(const Tracked& tracked) {
  if (!tracked.confirmed) return std::nullopt;
  const TentativePose& confirmed = *tracked.confirmed;
  const Rigid3d& world_from_camera = confirmed.view.world_from_view;
  if (keeper()) {
    keeper()->AddFrame(confirmed.frame, world_from_camera, confirmed.icp,
                       confirmed.view.view.pyramid);
  }
  PosedFrame posed;
  posed.index = confirmed.frame.index;
  posed.stamp_s = confirmed.frame.stamp_s;
  posed.world_from_camera = world_from_camera;
  return posed;
}

bool Slam::IsHeldOut(const Tracked& tracked) const {
  const bool begins_map = !tracker_->state().HasStarted() || tracked.state == FrameState::kNewMap;
  return options_.hold_out > 0 && !begins_map && frame_count_ % options_.hold_out == 0;
}

void Slam::Fuse(const PreprocessedFrame& frame, const Tracked& tracked, FrameReport* report,
                StageTimes* times) {
  const bool must = tracked.state == FrameState::kFirst || tracked.state == FrameState::kGiven ||
                    tracked.found_by_search || tracked.quality.is_by_newest ||
                    (tracker_->state().NeedsAllPoints() && !mapper_->has_longer_period());
  if (report->is_held_out || use_ == StateUse::kLocalize ||
      (!must && !mapper_->IsTurnToFuse(frame, tracked.world_from_camera))) {
    mapper_->Skip();
    return;
  }
  const StageTimer timer("fuse", frame.images.index, &times->fuse_ms);
  report->is_fused = true;
  report->fusion = mapper_->Fuse(frame, tracked.world_from_camera,
                                 tracker_->MotionTo(frame.images.stamp_s, tracked));
}

void Slam::OnPose(std::function<void(const FrameReport&)> call) { on_pose_ = std::move(call); }

void Slam::OnLostFrame(std::function<void(const LostFrame&)> call) {
  tracker_->OnLostFrame(std::move(call));
}

void Slam::UsePriorPoses(Trajectory world_from_body) {
  if (world_from_body.size() < 2) {
    throw InputError(
        Concat("the prior has ", world_from_body.size(), " poses, must have at least 2"));
  }
  ThrowIf(tracker_->state().HasStarted(), "prior poses must be set before the first frame");
  tracker_->UsePriorPoses(std::move(world_from_body));
  if (!backend_) MakeBackend({});
  UsePriorEdges();
}

// Connects consecutive keyframes by the motion of the prior poses.
void Slam::UsePriorEdges() {
  if (!backend_ || !tracker_->prior_poses()) return;
  backend_->UsePriorMotions([this](double from_s, double to_s) -> std::optional<PriorEdge> {
    const PriorPoses& prior = *tracker_->prior_poses();
    const std::optional<PriorMotion> motion = prior.Accepted(from_s, to_s);
    if (!motion) return std::nullopt;
    return PriorEdge{*prior.CameraAt(from_s), *prior.CameraAt(to_s), motion->covariance,
                     prior.RegisteredDrift(to_s - from_s), prior.RegistrationNoise()};
  });
}

std::optional<PriorPoseSummary> Slam::prior_poses() const {
  if (!tracker_->prior_poses()) return std::nullopt;
  return tracker_->prior_poses()->Summary();
}

void Slam::UseLoopFinder(LoopFinder finder) {
  ThrowIf(!options_.loops.HasViews(),
          "loops.enabled and loops.relocalization are false, one must be true for a loop finder");
  ThrowIf(!backend_->poses().frames().empty(), "a loop finder must be set before the first frame");
  MakeBackend(std::move(finder));
}

void Slam::OnKeyframe(KeyframeCall call) {
  ThrowIf(!options_.loops.HasViews(),
          "loops.enabled and loops.relocalization are false, one must be true for a callback for "
          "keyframes");
  on_keyframe_ = std::move(call);
  backend_->OnKeyframe(on_keyframe_);
}

void Slam::SetMapPeriod(int frames) {
  if (frames < 1) throw InputError(Concat("frames is ", frames, ", must be at least 1"));
  mapper_->SetPeriod(frames);
  tracker_->Hurry(mapper_->has_longer_period());
}

void Slam::Finish() {
  if (!keeper() || keeper()->poses().frames().empty()) return;
  for (const WorldCorrection& correction : keeper()->Finish()) {
    Apply(correction, keeper()->poses().frames().back().index);
  }
  SmoothByImu();
  if (const std::optional<WorldCorrection> apart = keeper()->PlacePieces(mapper_->Boxes())) {
    Apply(*apart, keeper()->poses().frames().back().index);
  }
}

const SurfelMap& Slam::map() const { return mapper_->map(); }

std::size_t Slam::merged_duplicates() const { return mapper_->merged_duplicates(); }

int Slam::corrections_of_map() const { return mapper_->corrections(); }

DepthSensor Slam::sensor() const { return mapper_->sensor(); }

const Backend* Slam::backend() const { return backend_.get(); }

}  // namespace surfit
