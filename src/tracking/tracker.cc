#include "tracking/tracker.h"

#include <glog/logging.h>

#include <algorithm>
#include <vector>

#include "frame/rolling_shutter.h"
#include "tracking/pose_validation.h"

namespace surfit {
namespace {

constexpr std::size_t kReadoutLevel = 3;
// Minimum inlier ratio of a pose that is certain by depth alone.
constexpr double kCertainInliers = 0.6;

}  // namespace

Tracker::Tracker(const TrackingOptions& options, const Rigid3d& world_from_first_camera,
                 ModelViews* views)
    : options_(options),
      views_(views),
      registration_(options, regions_),
      search_(options, registration_, &regions_, views),
      features_(options.icp.error_model),
      last_{{}, world_from_first_camera, {}},
      motion_model_(options) {}

void Tracker::UseRelocalizer(Relocalizer* relocalizer) {
  relocalizer_ = relocalizer;
  search_.UseRelocalizer(relocalizer);
}

void Tracker::UsePriorPoses(Trajectory world_from_body) {
  prior_poses_.emplace(std::move(world_from_body));
}

void Tracker::StartInGivenMap(double last_stamp_s) {
  state_ = TrackingState::InGivenMap();
  last_stamp_s_ = last_stamp_s;
}

void Tracker::UseImu(ImuRecording recording) {
  imu_ = std::make_unique<ImuTracking>(std::move(recording));
}

CameraMotion Tracker::ExpectedMotion(double stamp_s) const {
  CameraMotion motion = motion_model_.PredictMotion(state_);
  if (!imu_) return motion;
  if (const auto rate = imu_->CameraRate(stamp_s)) motion.angular_velocity_rad_per_s = *rate;
  return motion;
}

bool Tracker::NeedsIntensities() const {
  return options_.icp.error_model.UsesIntensities() ||
         (options_.weakly_constrained_photometric_weight > 0 && state_.NeedsAllPoints());
}

CameraMotion Tracker::MotionTo(double stamp_s, const Rigid3d& world_from_camera) const {
  return MotionModel::Velocity(state_, last_.world_from_view.Inverse() * world_from_camera,
                               stamp_s - last_stamp_s_);
}

CameraMotion Tracker::MotionTo(double stamp_s, const Tracked& tracked) const {
  return tracked.found_by_search ? CameraMotion() : MotionTo(stamp_s, tracked.world_from_camera);
}

bool Tracker::IsDuplicate(const RgbdFrame& frame) {
  const bool repeats = state_.HasStarted() && frame.depth_m == last_depth_m_;
  last_depth_m_ = frame.depth_m;
  return repeats;
}

bool Tracker::AcceptsColor(const RgbdFrame& frame) {
  const bool accepts = color_trust_.Accepts(frame.color, !(frame.depth_m == last_depth_m_));
  if (!accepts) WarnOfColor(frame.index);
  return accepts;
}

void Tracker::WarnOfColor(int frame) {
  if (std::exchange(warned_of_color_, true)) return;
  LOG(WARNING) << "frame " << frame
               << ": colour contradicts depth, so tracking uses depth alone: colour is of another "
                  "time, frozen, rotated, or of another camera";
}

Tracked Tracker::Repeat() const {
  Tracked tracked;
  tracked.state = state_.lost_frames > 0 ? FrameState::kLost : FrameState::kDuplicate;
  tracked.world_from_camera = last_.world_from_view;
  return tracked;
}

Tracked Tracker::TrackGiven(const PreprocessedFrame& frame, const Rigid3d& world_from_camera) {
  Tracked tracked;
  tracked.state = FrameState::kGiven;
  tracked.world_from_camera = world_from_camera;
  regions_.Remember(frame.surface(), tracked.moving, world_from_camera, frame.images.stamp_s);
  return tracked;
}

Prediction Tracker::Predict(const PreprocessedFrame& frame) {
  prior_motion_.reset();
  if (prior_poses_ && !imu_ && state_.HasStarted() && state_.is_localised &&
      !state_.IsTentative()) {
    prior_motion_ = prior_poses_->Trusted(last_stamp_s_, frame.images.stamp_s);
  }
  return PredictAt(frame);
}

// Predicts by the inertial sensor, else by the prior poses, else by the motion model.
Prediction Tracker::PredictAt(const PreprocessedFrame& frame) {
  Prediction prediction;
  imu_prediction_ = PredictByImu(frame.images.stamp_s);
  if (imu_prediction_) {
    prediction.world_from_camera = imu_prediction_->world_from_camera;
  } else if (prior_motion_) {
    prediction.world_from_camera = last_.world_from_view * prior_motion_->last_from_frame;
  } else {
    prediction.world_from_camera = PredictedPose(SecondsTo(frame));
  }
  prediction.has_own_view =
      options_.IsFrameToFrame() || UpdateView(prediction.world_from_camera, frame.HasIntensities());
  prediction.reference = options_.IsFrameToFrame() ? &last_ : &views_->View();
  return prediction;
}

Tracked Tracker::Track(const PreprocessedFrame& frame, const Prediction& prediction) {
  Tracked tracked = Register(frame, *prediction.reference, prediction.world_from_camera);
  if (LacksIntensities(frame, tracked)) {
    PreprocessedFrame textured = frame;
    AddIntensity(frame.images.color, &textured.view.pyramid);
    return Track(textured, PredictAt(textured));
  }
  const CellMask moving = MovingCells(frame, tracked);
  if (moving.empty()) {
    return CheckFeatures(frame, TrackFrom(frame, prediction, std::move(tracked)));
  }
  PreprocessedFrame rest = frame;
  rest.view.pyramid = Without(std::move(rest.view.pyramid), moving);
  tracked = Register(rest, *prediction.reference, prediction.world_from_camera);
  tracked = TrackFrom(rest, prediction, std::move(tracked));
  tracked.moving_ratio = AddMoving(frame.surface(), moving, &tracked.moving);
  return CheckFeatures(frame, std::move(tracked));
}

// The first weakly constrained frame has no intensities yet.
bool Tracker::LacksIntensities(const PreprocessedFrame& frame, const Tracked& tracked) const {
  return tracked.quality.is_weakly_constrained && !frame.HasIntensities() &&
         !frame.images.color.empty() && !options_.IsFrameToFrame() &&
         options_.weakly_constrained_photometric_weight > 0;
}

// Returns the moving cells if the pose contradicts the motion of static corners. A pose with many
// inliers is certain, and repetitive texture can confuse corners. Objects that move since the map
// began have no free space behind them. Later objects are found by free space, and make frames
// doubtful.
CellMask Tracker::MovingCells(const PreprocessedFrame& frame, const Tracked& tracked) {
  const bool is_doubtful =
      !tracked.has_pose() || tracked.verdict != Verdict::kAccepted || !tracked.moving.empty();
  if (is_doubtful) WatchCorners(frame);
  corners_.Follow(frame.view, frame.images.stamp_s);
  if (tracked.has_pose() && tracked.icp.inlier_ratio >= kCertainInliers) return {};
  CellMask moving = corners_.Contradicting(
      tracked.has_pose() ? std::optional(tracked.world_from_camera) : std::nullopt);
  if (moving.empty() || CountNormals(frame, moving) < options_.icp.min_inliers) return {};
  return moving;
}

void Tracker::WatchCorners(const PreprocessedFrame& frame) {
  if (options_.VerifiesBySearch()) corners_.Watch(frame.images.stamp_s);
}

Tracked Tracker::TrackFrom(const PreprocessedFrame& frame, const Prediction& prediction,
                           Tracked tracked) {
  if (!prior_motion_ || AgreesWithPrior(frame, tracked, prediction)) {
    return RegisterOrSearch(frame, prediction, std::move(tracked));
  }
  prior_motion_.reset();
  const Prediction without = PredictAt(frame);
  tracked = Register(frame, *without.reference, without.world_from_camera);
  return RegisterOrSearch(frame, without, std::move(tracked));
}

Tracked Tracker::TrackFirst(const PreprocessedFrame& frame) {
  Tracked tracked;
  tracked.state = HasEnoughDepth(frame, options_.icp) ? FrameState::kFirst : FrameState::kLost;
  tracked.world_from_camera = last_.world_from_view;
  tracked.quality.is_first = true;
  WatchCorners(frame);
  corners_.Follow(frame.view, frame.images.stamp_s);
  return CheckFeatures(frame, std::move(tracked));
}

Tracked Tracker::CheckFeatures(const PreprocessedFrame& frame, Tracked tracked) {
  const bool changes_submap = tracked.submap && *tracked.submap != submap_;
  if (changes_submap) {
    WatchCorners(frame);
    corners_.Forget();
    features_.Forget();
  }
  if (options_.VerifiesBySearch()) {
    CameraMotion since_last;
    if (tracked.has_pose() && state_.is_localised && !changes_submap) {
      since_last =
          MotionOver(last_.world_from_view.Inverse() * tracked.world_from_camera, SecondsTo(frame));
    }
    const FrameState state = tracked.state;
    tracked = ValidateByFeatures(frame, std::move(tracked), since_last, &features_);
    const bool is_rejected = state != FrameState::kLost && !tracked.has_pose();
    if (is_rejected && tracked.is_certain_by_depth && !color_trust_.TrustsFeatures(frame.images)) {
      WarnOfColor(frame.images.index);
      tracked.state = state;
      tracked.has_two_motions = false;
    }
  }
  corners_.Remember(tracked.has_pose() ? std::optional(tracked.world_from_camera) : std::nullopt);
  if (tracked.has_pose()) {
    regions_.Remember(frame.surface(), tracked.moving, tracked.world_from_camera,
                      frame.images.stamp_s);
  }
  return tracked;
}

Tracked Tracker::RegisterOrSearch(const PreprocessedFrame& frame, const Prediction& prediction,
                                  Tracked registered) {
  const ReferenceView& reference = *prediction.reference;
  Tracked tracked = ByDepthAlone(frame, prediction, std::move(registered));
  tracked = WithoutImu(frame, prediction, std::move(tracked));
  if (state_.HasLastPose() && !options_.IsFrameToFrame() && MayShowNewSurfaces(tracked)) {
    tracked = AgainstNewest(frame, std::move(tracked));
  }
  if (std::optional<Tracked> confirmed = CompareWithTentative(frame, &tracked)) {
    tracked = *std::move(confirmed);
  } else if (!AgreesWithImu(tracked) && !IsHeldByPrior(tracked)) {
    tracked = Verified(frame, prediction, std::move(tracked));
  }
  tracked.has_own_view = prediction.has_own_view;
  if (tracked.has_pose()) {
    const Rigid3d moved = WithMeasuredMotion(frame, tracked);
    tracked.world_from_registered =
        tracked.world_from_registered * (tracked.world_from_camera.Inverse() * moved);
    tracked.world_from_camera = moved;
    return tracked;
  }
  if (on_lost_) {
    on_lost_({frame.images.index, frame.view.pyramid, reference.view.pyramid, frame.images.color,
              reference.view.color,
              reference.world_from_view.Inverse() * prediction.world_from_camera, tracked.icp,
              IcpOptionsInUse()});
  }
  return InNewSubmap(frame, tracked).value_or(tracked);
}

// Half of the rows take 0.6 of the time. The ATE of desk and kitchen then differs by at most 4 %.
IcpOptions Tracker::IcpOptionsInUse() const {
  IcpOptions icp_options = options_.icp;
  if (registration_.is_hurried()) {
    icp_options.min_source_rows /= 2;
  } else if (state_.last.is_weakly_constrained) {
    icp_options.min_source_rows = 0;
  }
  return icp_options;
}

Tracked Tracker::Register(const PreprocessedFrame& frame, const ReferenceView& reference,
                          const Rigid3d& world_from_predicted) const {
  return registration_.Register(frame, reference, world_from_predicted, IcpOptionsInUse(),
                                PredictedUncertainty(frame));
}

// Accepts a pose that brightness contradicts, if it is certain by depth.
Tracked Tracker::ByDepthAlone(const PreprocessedFrame& frame, const Prediction& prediction,
                              Tracked tracked) {
  tracked.is_certain_by_depth =
      (tracked.verdict == Verdict::kAccepted || tracked.is_color_contradicted) &&
      state_.HasLastPose() && tracked.icp.Succeeded() && tracked.moving.empty() &&
      !tracked.quality.is_weakly_constrained && tracked.icp.inlier_ratio >= kCertainInliers &&
      AreOnePlace(prediction.world_from_camera, tracked.world_from_camera);
  if (!tracked.is_certain_by_depth || frame.images.color.empty()) return tracked;
  color_trust_.AddBrightness(!tracked.is_color_contradicted);
  if (!tracked.is_color_contradicted || color_trust_.is_proven()) return tracked;
  tracked.verdict = Verdict::kAccepted;
  tracked.state = FrameState::kTracked;
  return tracked;
}

// Registers a frame to all surfels, because it may show surfaces whose surfels are not stable
// yet. Returns this registration if it is accepted and agrees with the pose of `tracked`.
Tracked Tracker::AgainstNewest(const PreprocessedFrame& frame, Tracked tracked) const {
  const Rigid3d& pose = tracked.world_from_camera;
  Tracked by_newest = Register(frame, views_->NewestViewAt(pose, frame.HasIntensities()), pose);
  const bool is_accepted = by_newest.has_pose() && by_newest.verdict == Verdict::kAccepted;
  if (!is_accepted || !AreOnePlace(pose, by_newest.world_from_camera)) return tracked;
  by_newest.has_second = by_newest.quality.is_by_newest = true;
  return by_newest;
}

// Replaces the predicted motion during the readout by the measured motion.
Rigid3d Tracker::WithMeasuredMotion(const PreprocessedFrame& frame, const Tracked& tracked) const {
  CameraMotion motion = MotionTo(frame.images.stamp_s, tracked);
  // The gyroscope has already given the rotation at the time of the frame.
  if (imu_ && imu_->CameraRate(frame.images.stamp_s) && !motion.IsZero())
    motion.angular_velocity_rad_per_s = frame.motion.angular_velocity_rad_per_s;
  const bool is_free = !tracked.icp.degenerate_directions.empty();
  if (frame.readout_s == 0 || motion.IsZero() || is_free) return tracked.world_from_camera;
  const std::vector<FrameLevel>& levels = frame.view.pyramid.levels;
  return tracked.world_from_camera *
         ReadoutCorrection(levels[std::min(kReadoutLevel, levels.size() - 1)], frame.readout_s,
                           frame.motion, motion, SecondsTo(frame));
}

std::optional<Tracked> Tracker::InNewSubmap(const PreprocessedFrame& frame,
                                            const Tracked& tracked) {
  if (!relocalizer_ || !HasEnoughDepth(frame, options_.icp)) return std::nullopt;
  regions_.Follow(frame.surface());
  if (tracked.tentative) return std::nullopt;
  CellMask moving = regions_.Followed();
  // A third of the view must be static, so that the moving object does not become the map.
  const int points = CountNormals(frame, moving);
  if (points < options_.icp.min_inliers || 3 * points < CountNormals(frame)) return std::nullopt;
  const std::optional<int> begun = relocalizer_->BeginSubmap(lost_with_depth_ + 1);
  if (!begun) return std::nullopt;
  views_->UseSubmap(*begun);
  regions_.Forget();
  Tracked first = tracked;
  first.state = FrameState::kNewMap;
  first.moving = std::move(moving);
  first.world_from_camera = last_.world_from_view;
  first.submap = *begun;
  return first;
}

void Tracker::Update(PreprocessedFrame frame, Tracked tracked) {
  tentative_ = std::move(tracked.tentative);
  if (!tracked.has_pose()) {
    lost_with_depth_ += HasEnoughDepth(frame, options_.icp);
    state_ = Next(state_, tentative_ ? TrackingEvent::kTentativePose : TrackingEvent::kNoPose);
    motion_model_.Lose(state_);
    imu_prediction_.reset();
    return;
  }
  lost_with_depth_ = 0;
  AddToImu(frame, tracked);
  submap_ = tracked.submap.value_or(submap_);
  const std::optional<Rigid3d> expected = ExpectedPose(frame);
  motion_model_.Update(state_, {last_.world_from_view.Inverse() * tracked.world_from_camera,
                                SecondsTo(frame), tracked.found_by_search,
                                expected && AreOnePlace(*expected, tracked.world_from_camera),
                                tracked.motion_covariance});
  if (prior_poses_) ComparePrior(frame, tracked);
  last_stamp_s_ = frame.images.stamp_s;
  if (options_.IsFrameToFrame() || options_.initialize != "identity") {
    last_.view = std::move(frame.view);
  }
  last_.world_from_view = tracked.world_from_camera;
  state_ = Next(state_, tracked.found_by_search ? TrackingEvent::kFound : TrackingEvent::kPose,
                tracked.quality);
}

void Tracker::PredictAhead(bool has_color) {
  constexpr double kUnknown_s = 0;
  // The inertial prediction needs the time of the next frame.
  const bool needs_time = imu_ && imu_->IsActive();
  if (options_.IsFrameToFrame() || needs_time) return;
  UpdateView(PredictedPose(kUnknown_s), NeedsIntensities() && has_color);
}

// With photometric residuals, each frame needs its own view: shared views double the maximum
// error in front of textured walls.
bool Tracker::UpdateView(const Rigid3d& world_from_predicted, bool has_intensities) {
  return views_->Update(world_from_predicted, state_.NeedsAllPoints() || has_intensities,
                        has_intensities);
}

Rigid3d Tracker::PredictedPose(double seconds) const {
  if (state_.IsTentative()) return tentative_->view.world_from_view;
  return motion_model_.PredictPose(state_, last_.world_from_view, seconds);
}

// Returns std::nullopt without a motion prior.
std::optional<Rigid3d> Tracker::ExpectedPose(const PreprocessedFrame& frame) const {
  if (!motion_model_.HasPredictableMotion(state_)) return std::nullopt;
  return PredictedPose(SecondsTo(frame));
}

void Tracker::Move(const Rigid3d& new_from_old_now,
                   const std::function<Rigid3d(int frame)>& new_from_old_at) {
  last_.world_from_view = new_from_old_now * last_.world_from_view;
  world_from_registered_ = new_from_old_now * world_from_registered_;
  regions_.Move(new_from_old_now);
  features_.Move(new_from_old_now);
  corners_.Move(new_from_old_now);
  if (imu_) imu_->Move(new_from_old_now);
  if (!tentative_) return;
  const Rigid3d new_from_old = tentative_->submap == submap_
                                   ? new_from_old_now
                                   : new_from_old_at(tentative_->keyframe_frame);
  tentative_->view.world_from_view = new_from_old * tentative_->view.world_from_view;
}

}  // namespace surfit
