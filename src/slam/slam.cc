#include "surfit/slam/slam.h"

#include <glog/logging.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "surfit/core/options.h"
#include "surfit/core/trace.h"
#include "surfit/frame/intensity.h"
#include "surfit/mapping/merge_doubles.h"
#include "surfit/mapping/move_map.h"
#include "surfit/registration/align_rotation.h"

namespace surfit {
namespace {

// Of lost frames every fifth is looked for: that takes as long as tracking tens of frames.
constexpr int kSearchStride = 5;
constexpr int kRelocalizeStride = 3;  // the same of the search among keyframes

double MeanDepth(const Image<float>& depth_m) {
  const auto count = std::count_if(depth_m.begin(), depth_m.end(), [](float z) { return z > 0; });
  const double sum = std::accumulate(depth_m.begin(), depth_m.end(), 0.);
  return count > 0 ? sum / static_cast<double>(count) : 0;
}

// How far a motion moves the middle of an image of what the level shows, as a share of its width.
double ImageShift(const Rigid3d& motion, const FrameLevel& level) {
  const double depth_m = MeanDepth(level.vertex.z);
  if (depth_m == 0) return std::numeric_limits<double>::infinity();
  const double turn_rad = RotationAngle(motion.rotation);
  const PinholeCamera& camera = level.camera;
  return camera.fx / camera.width * (turn_rad + motion.translation.norm() / depth_m);
}

// Made whole: the fusion knows nothing of loops.
SlamOptions Validated(SlamOptions options) {
  Validate(options);
  int& active_frames = options.fusion.active_frames;
  if (options.loops.enabled && active_frames == 0) active_frames = options.loops.active_frames;
  return options;
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

Slam::Slam(const DepthSensor& sensor, const SlamOptions& options,
           const Rigid3d& world_from_first_camera)
    : sensor_(sensor),
      options_(Validated(options)),
      renderer_(options_.render),
      fusion_(options_.fusion),
      world_from_last_(world_from_first_camera) {
  sensor.Validate();
  if (options.loops.enabled) backend_ = std::make_unique<Backend>(options.loops);
}

void Slam::UseLoopFinder(LoopFinder finder) {
  CHECK(backend_ && backend_->frames().empty());
  backend_ = std::make_unique<Backend>(options_.loops, std::move(finder));
}

FrameReport Slam::Process(const RgbdFrame& frame) { return Process(frame, std::nullopt); }

FrameReport Slam::ProcessAt(const RgbdFrame& frame, const Rigid3d& world_from_camera) {
  return Process(frame, world_from_camera);
}

FrameReport Slam::Process(const RgbdFrame& frame, const std::optional<Rigid3d>& given_pose) {
  CHECK_EQ(frame.depth_m.width(), sensor_.camera.width);
  CHECK_EQ(frame.depth_m.height(), sensor_.camera.height);
  CHECK(frame.color.empty() || frame.color.size() == frame.depth_m.size());
  FrameReport report;
  report.index = frame.index;
  report.stamp_s = frame.stamp_s;
  if (backend_) {
    const StageTimer timer("correct", report.index, &report.times.correct_ms);
    if (const auto correction = backend_->BeginFrame()) Correct(*correction, report.index);
  }
  const bool frozen = started_ && !given_pose && frame.depth_m == last_depth_m_;
  last_depth_m_ = frame.depth_m;
  if (frozen) {
    report.state = lost_count_ > 0 ? FrameState::kLost : FrameState::kFrozen;
    report.world_from_camera = world_from_last_;
    if (backend_ && lost_count_ == 0) backend_->AddFrozenFrame(report.index, report.stamp_s);
    return report;
  }

  FramePyramid pyramid;
  {
    StageTimer timer("preprocess", report.index, &report.times.preprocess_ms);
    pyramid = PreprocessDepth(frame.depth_m, sensor_, options_.preprocess);
    if (options_.icp.error_model.UsesIntensities()) AddIntensity(frame.color, &pyramid);
  }
  if (given_pose) {
    report.state = FrameState::kGiven;
    report.world_from_camera = *given_pose;
  } else if (!started_) {
    report.state = CanStart(pyramid) ? FrameState::kFirst : FrameState::kLost;
    report.world_from_camera = world_from_last_;
  } else {
    Track(frame, pyramid, &report);
  }
  if (backend_) BeginSubmapIfLongLost(pyramid, &report);
  const bool lost = report.state == FrameState::kLost;
  if (!lost) {
    if (backend_) {
      backend_->AddFrame(report.index, report.stamp_s, report.world_from_camera, report.icp,
                         pyramid, frame.color);
    }
    if (IsToBeFused(report)) Fuse(frame, pyramid, &report);
    unfused_count_ = report.is_fused ? 0 : unfused_count_ + 1;
    KeepAsLast(frame, std::move(pyramid), report);
  }
  lost_count_ = lost ? lost_count_ + 1 : 0;
  return report;
}

void Slam::Track(const RgbdFrame& frame, const FramePyramid& pyramid, FrameReport* report) {
  Rigid3d world_from_predicted;
  {
    StageTimer timer("predict", report->index, &report->times.predict_ms);
    world_from_predicted = PredictedPose(frame, pyramid);
    report->has_own_view = NeedsNewTarget(pyramid, world_from_predicted);
    if (report->has_own_view) target_ = MakeTarget(world_from_predicted);
  }
  const Rigid3d initial = target_.world_from_target.Inverse() * world_from_predicted;
  StageTimer timer("track", report->index, &report->times.track_ms);
  IcpOptions icp_options = options_.icp;
  if (is_poorly_held_) icp_options.min_source_rows = 0;
  report->icp = Register(pyramid, target_.pyramid, initial, icp_options);
  report->world_from_camera = target_.world_from_target * report->icp.target_from_source;
  const bool found = IsBelievable(report->icp) || FindAgain(frame, pyramid, report);
  const bool relocalized = !found && Relocalize(frame, pyramid, report);
  const bool tracked = found || relocalized;
  const bool degenerate = !report->icp.free_directions.empty();
  report->state = !tracked      ? FrameState::kLost
                  : relocalized ? FrameState::kRelocalized
                  : degenerate  ? FrameState::kDegenerate
                                : FrameState::kTracked;
  if (!tracked && on_lost_) {
    on_lost_({report->index, pyramid, target_.pyramid, frame.color, target_.color, initial,
              report->icp});
  }
}

// From the last good frame as far as the views tell, and from there against the map.
bool Slam::FindAgain(const RgbdFrame& frame, const FramePyramid& pyramid, FrameReport* report) {
  if (options_.initialize == "identity" || lost_count_ % kSearchStride != 0) return false;
  if (!CanStart(pyramid)) return false;
  const TraceSlice slice("find_again", report->index);
  InitializeOptions initialization;
  initialization.method = options_.initialize;
  const InitializedIcpResult found =
      InitializeAndRegister({pyramid, frame.color}, last_view_, initialization, FarIcpOptions());
  if (!found.icp.Succeeded()) return false;
  return AgreesWithMap(pyramid, world_from_last_ * found.icp.target_from_source, report);
}

// By a keyframe that shows the same place, and from there against the map.
bool Slam::Relocalize(const RgbdFrame& frame, const FramePyramid& pyramid, FrameReport* report) {
  if (!backend_ || lost_count_ % kRelocalizeStride != 0 || !CanStart(pyramid)) return false;
  const Relocalization found = backend_->Find({pyramid, frame.color});
  if (!found.found()) return false;
  WakeAround(backend_->FrameOfKeyframe(found.keyframe), report->index);
  if (!AgreesWithMap(pyramid, found.world_from_camera, report)) return false;
  backend_->AfterRelocalization(found.keyframe);
  return true;
}

// Takes the pose that registration to the map finds from there, if it is believable.
bool Slam::AgreesWithMap(const FramePyramid& pyramid, const Rigid3d& world_from_found,
                         FrameReport* report) {
  const Target target = MakeTarget(world_from_found);
  const IcpResult icp = Register(
      pyramid, target.pyramid, target.world_from_target.Inverse() * world_from_found, options_.icp);
  if (!IsBelievable(icp)) return false;
  report->icp = icp;
  report->world_from_camera = target.world_from_target * icp.target_from_source;
  report->found_again = true;
  return true;
}

Rigid3d Slam::PredictedPose(const RgbdFrame& frame, const FramePyramid& pyramid) const {
  if (options_.motion_model == "so3") {
    const ViewPair views = {pyramid, frame.color, last_view_.pyramid, last_view_.color};
    return world_from_last_ * AlignRotation(views, Rigid3d());
  }
  // After a loss the motion is unknown: start where the camera was last seen.
  if (lost_count_ > 0 || options_.motion_model == "constant_pose") return world_from_last_;
  return world_from_last_ * last_from_next_;
}

// In turn with fusion, so that no frame takes the time of both; else where the last one shows
// little of what this frame sees. Intensities are compared more finely than surfaces: with views
// that frames share the largest error before textured walls is twice as large.
bool Slam::NeedsNewTarget(const FramePyramid& pyramid, const Rigid3d& world_from_predicted) const {
  const bool is_its_turn = unfused_count_ == 0 || is_poorly_held_;
  if (is_its_turn || lost_count_ > 0 || options_.tracking == "frame_to_frame") return true;
  if (!pyramid.levels.front().intensity.empty()) return true;
  const Rigid3d target_from_predicted = target_.world_from_target.Inverse() * world_from_predicted;
  return ImageShift(target_from_predicted, target_.pyramid.levels.back()) > options_.max_view_shift;
}

Slam::Target Slam::MakeTarget(const Rigid3d& world_from_predicted) {
  if (options_.tracking == "frame_to_frame") {
    return {last_view_.pyramid, world_from_last_, last_view_.color};
  }
  ModelView view = renderer_.Render(map_, sensor_, world_from_predicted, fusion_.ActiveSince());
  DropNormalsAtEdges(options_.preprocess, &view.surface);
  Target target = {
      BuildPyramid(std::move(view.surface), options_.preprocess), world_from_predicted, {}};
  if (options_.icp.error_model.UsesIntensities()) {
    // The map's colours keep the pose from drifting as it would against the last frame's, by which
    // ATE was larger: by a seventh in simulated rooms, 5 and 8 times before a ball and a wall.
    target.color = ColorsOf(view, map_);
    AddIntensity(target.color, &target.pyramid);
  }
  return target;
}

bool Slam::IsBelievable(const IcpResult& icp) const {
  const bool is_degenerate = icp.termination == Termination::kSingularSystem;
  return (icp.Succeeded() || is_degenerate) && icp.inlier_share >= options_.min_inlier_share &&
         icp.rmse_m <= options_.max_rmse_m;
}

bool Slam::CanStart(const FramePyramid& pyramid) const {
  const Image<float>& normal_z = pyramid.levels.front().normal.z;
  const auto points =
      std::count_if(normal_z.begin(), normal_z.end(), [](float z) { return z < 0; });
  return points >= options_.icp.min_inliers;
}

void Slam::BeginSubmapIfLongLost(const FramePyramid& pyramid, FrameReport* report) {
  const int after = options_.loops.new_map_after;
  if (report->state != FrameState::kLost || !started_ || after == 0) return;
  if (lost_count_ + 1 < after || !CanStart(pyramid)) return;
  report->state = FrameState::kNewMap;
  report->world_from_camera = backend_->BeginSubmap(world_from_last_);
}

void Slam::Finish() {
  if (!backend_ || backend_->frames().empty()) return;
  while (const auto correction = backend_->Finish()) {
    Correct(*correction, backend_->frames().back().index);
  }
}

// The map moves as the camera does, so that tracking goes on as if nothing had been.
void Slam::Correct(const WorldCorrection& correction, int frame_index) {
  const int active_frames = options_.fusion.active_frames;
  if (correction.moves) {
    MoveMap(correction.corrections, &map_);
    world_from_last_ = correction.new_from_old_now * world_from_last_;
    target_.world_from_target = correction.new_from_old_now * target_.world_from_target;
  }
  if (correction.moves || active_frames > 0) {
    DoublesOptions doubles;
    doubles.frames_apart = std::max(active_frames, options_.loops.frames_apart);
    if (!correction.moves) doubles.newer_since = merged_until_;  // before that nothing has changed
    merged_doubles_ += MergeDoubles(options_.fusion, doubles, &map_);
    merged_until_ = frame_index;
  }
  for (const int joined : correction.joined) WakeAround(joined, frame_index);
}

// What was seen around the time of a frame is near again.
void Slam::WakeAround(int frame_index, int now) {
  const int active_frames = options_.fusion.active_frames;
  if (active_frames == 0) return;
  WakeSurfels(frame_index - active_frames, frame_index + active_frames, now, &map_);
}

// In its turn, and at once where the map may not have been seen from.
bool Slam::IsToBeFused(const FrameReport& report) const {
  return report.state == FrameState::kFirst || report.state == FrameState::kGiven ||
         lost_count_ > 0 || report.found_again || is_poorly_held_ ||
         unfused_count_ + 1 >= options_.map_period;
}

void Slam::Fuse(const RgbdFrame& frame, const FramePyramid& pyramid, FrameReport* report) {
  StageTimer timer("fuse", report->index, &report->times.fuse_ms);
  report->fusion = fusion_.Fuse(frame, pyramid.levels.front(), report->world_from_camera, &map_);
  report->is_fused = true;
}

// What the next frame needs to know of this one.
void Slam::KeepAsLast(const RgbdFrame& frame, FramePyramid pyramid, const FrameReport& report) {
  // The way over lost frames is not one frame's motion, nor is a jump.
  const bool is_next = started_ && lost_count_ == 0 && !report.found_again;
  is_poorly_held_ =
      !report.icp.iterations.empty() && report.icp.eigenvalues[0] < options_.min_turn_eigenvalue;
  last_from_next_ = is_next ? world_from_last_.Inverse() * report.world_from_camera : Rigid3d();
  world_from_last_ = report.world_from_camera;
  if (options_.tracking == "frame_to_frame" || options_.initialize != "identity" ||
      options_.motion_model == "so3") {
    last_view_ = {std::move(pyramid), frame.color};
  }
  started_ = true;
}

}  // namespace surfit
