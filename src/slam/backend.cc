#include "surfit/slam/backend.h"

#include <algorithm>

#include "calibration/calibrator.h"
#include "loop_closure/correct_frames.h"
#include "loop_closure/edge_information.h"
#include "loop_closure/loop_closer.h"
#include "surfit/core/options.h"

namespace surfit {
namespace {

const LoopOptions& Validated(const LoopOptions& options) {
  Validate(options);
  return options;
}

// Displacement by a correction, m: camera translation plus 2 m times the rotation angle.
double Displacement(const Rigid3d& new_from_old, const Eigen::Vector3d& camera) {
  constexpr double kDistanceM = 2;
  return (new_from_old * camera - camera).norm() +
         kDistanceM * RotationAngle(new_from_old.rotation);
}

// Moves pieces far apart, so that a calibration does not compare their surfaces.
void KeepPiecesApart(const PoseStore& poses, std::vector<Rigid3d>* keyframes,
                     Trajectory* trajectory) {
  constexpr double kApart_m = 100;
  const std::vector<int> pieces = poses.PieceOfKeyframe();
  for (std::size_t k = 0; k < keyframes->size(); ++k) {
    (*keyframes)[k].translation.x() += kApart_m * pieces[k];
  }
  for (std::size_t i = 0; i < trajectory->size(); ++i) {
    const double shift_m = kApart_m * pieces[poses.frames()[i].keyframe];
    (*trajectory)[i].world_from_camera.translation.x() += shift_m;
  }
}

}  // namespace

Backend::Backend(const DepthSensor& sensor, const PreprocessOptions& preprocess,
                 const LoopOptions& loops, const CalibrationOptions& calibration, LoopFinder finder,
                 bool real_time)
    : options_(Validated(loops)), real_time_(real_time) {
  if (loops.HasViews()) closer_ = std::make_unique<LoopCloser>(loops, std::move(finder), real_time);
  if (calibration.enabled) {
    calibrator_ = std::make_unique<Calibrator>(sensor, preprocess, calibration, real_time);
  }
}

Backend::~Backend() = default;

void Backend::ContinueFrom(SlamState* state, StateUse use) {
  const bool goes_on = use == StateUse::kContinue;
  if (!goes_on) state->settled_keyframes = state->keyframes.size();
  const std::size_t settled = state->settled_keyframes;
  poses_ = PoseStore(std::move(static_cast<StoredPoses&>(*state)));
  begins_submap_ = false;
  const PosedFrame& last = poses_.FrameOf(static_cast<int>(poses_.keyframes().size()) - 1);
  last_keyframe_ = {last.index, last.stamp_s, last.world_from_camera, state->views.back()};
  closer_->UseCalibration(state->calibration);
  TakeViews(std::move(state->views), settled);
  if (goes_on && !waiting_.empty()) StartLoopTask();
  if (calibrator_) {
    if (!goes_on) state->calibration_frames.clear();
    calibrator_->ContinueFrom(state->calibration, state->color_latency_s,
                              std::move(state->calibration_frames));
  }
}

// Adds keyframes of a saved state. The loop search is complete for the first `settled` keyframes.
// All other keyframes wait for a loop task.
void Backend::TakeViews(std::vector<PlaceView> views, std::size_t settled) {
  std::vector<Keyframe> keyframes;
  for (std::size_t k = 0; k < views.size(); ++k) {
    const PosedFrame& frame = poses_.FrameOf(static_cast<int>(k));
    if (k < settled) {
      keyframes.push_back(
          {frame.index, frame.stamp_s, frame.world_from_camera, std::move(views[k])});
    } else {
      const auto view = std::make_shared<PlaceView>(std::move(views[k]));
      waiting_.push_back({frame.index, frame.stamp_s, [view] { return *view; }});
    }
  }
  closer_->AddSettled(std::move(keyframes));
}

// Applies due tasks and returns their corrections. Loop and calibration tasks count frames
// separately. A loop task must not run while a calibration is applied.
std::vector<WorldCorrection> Backend::BeginFrame() {
  const auto is_due = [&](auto* task) {
    return real_time_ ? task->IsReadyAfterStep() : task->IsDueAfterStep();
  };
  const bool are_loops_due = closer_ && is_due(&closer_->task());
  const bool is_calibration_due = calibrator_ && is_due(&calibrator_->task());
  std::vector<WorldCorrection> corrections;
  if (are_loops_due) {
    counts_.waits += closer_->task().IsAtWork();
    TakeLoops(&corrections);
    StartLoopTaskIfFree();
  }
  if (is_calibration_due && !(real_time_ && closer_ && closer_->task().IsPending())) {
    counts_.waits += calibrator_->task().IsAtWork();
    if (!real_time_) FinishLoops(&corrections);
    TakeCalibration(&corrections);
    StartLoopTaskIfFree();
  }
  return corrections;
}

// In real time, a finished calibration is applied before another loop task starts.
void Backend::StartLoopTaskIfFree() {
  if (!closer_ || waiting_.empty() || closer_->task().IsPending()) return;
  if (real_time_ && calibrator_ && calibrator_->task().IsReady()) return;
  StartLoopTask();
}

void Backend::AddFrame(const RgbdFrame& frame, const Rigid3d& world_from_camera,
                       const IcpResult& icp, const FramePyramid& pyramid) {
  const bool begins_segment = begins_submap_ || anchor_;
  const int last_segment = poses_.frames().empty() ? -1 : poses_.frames().back().segment;
  const bool is_keyframe =
      begins_segment || BecomesKeyframe(frame.index, world_from_camera, pyramid);
  poses_.AddFrame(frame.index, frame.stamp_s, world_from_camera,
                  last_segment + (begins_segment ? 1 : 0));
  if (is_keyframe) AddKeyframe(frame, icp, pyramid);
}

void Backend::AddDuplicateFrame(int index, double stamp_s) {
  const PosedFrame& last = poses_.frames().back();
  poses_.AddFrame(index, stamp_s, last.world_from_camera, last.segment);
}

bool Backend::BecomesKeyframe(int frame_index, const Rigid3d& world_from_camera,
                              const FramePyramid& pyramid) {
  const int last = static_cast<int>(poses_.keyframes().size()) - 1;
  last_keyframe_->world_from_camera = poses_.FrameOf(last).world_from_camera;
  return IsKeyframe(*last_keyframe_, frame_index, pyramid.levels.front(), world_from_camera,
                    options_.keyframes);
}

void Backend::AddKeyframe(const RgbdFrame& frame, const IcpResult& icp,
                          const FramePyramid& pyramid) {
  const int last = static_cast<int>(poses_.keyframes().size()) - 1;
  const int parent = begins_submap_ ? KeyframeLink::kNone : anchor_.value_or(last);
  poses_.MakeKeyframe(parent);
  const PosedFrame& posed = poses_.frames().back();
  AddEdgeTo(posed, parent, icp);
  last_keyframe_ = {posed.index, posed.stamp_s, posed.world_from_camera,
                    MakeDepthView(pyramid, options_.views)};
  begins_submap_ = false;
  anchor_.reset();
  if (calibrator_) calibrator_->AddKeyframe(frame);
  if (closer_) {
    KeyframeForLoops added = {posed.index, posed.stamp_s,
                              ViewOf({pyramid, frame.color}, Field(), options_.views)};
    if (on_keyframe_) {
      on_keyframe_(posed.index, added.view, calibrator_ ? calibrator_->last_keyframe() : nullptr);
    }
    waiting_.push_back(std::move(added));
    StartLoopTaskIfFree();
  }
  if (calibrator_ && calibrator_->IsTaskDue()) StartCalibration();
}

void Backend::AddEdgeTo(const PosedFrame& keyframe, int parent, const IcpResult& icp) {
  if (parent == KeyframeLink::kNone) return;
  const PosedFrame& from = poses_.FrameOf(parent);
  PoseGraphEdge edge;
  edge.a = static_cast<std::size_t>(parent);
  edge.b = static_cast<std::size_t>(keyframe.keyframe);
  edge.a_from_b = from.world_from_camera.Inverse() * keyframe.world_from_camera;
  if (!anchor_) {
    edge.information =
        OdometryInformation(icp, keyframe.index - from.index, edge.a_from_b, options_.noise);
    poses_.AddEdge(edge);
    return;
  }
  edge.information = RelocalizationInformation(icp, edge.a_from_b, options_.noise);
  edge.loop = true;
  LoopRecord record;
  record.source_frame = keyframe.index;
  record.target_frame = from.index;
  record.in_graph = record.is_relocalization = true;
  record.attempt.proposal = {keyframe.keyframe, parent, 0, std::nullopt};
  record.attempt.verdict.reason = GlobalRegistrationReason::kAccepted;
  record.attempt.verdict.target_from_source = edge.a_from_b;
  record.attempt.verdict.icp = icp;
  record.attempt.verdict.inlier_ratio = icp.inlier_ratio;
  record.attempt.verdict.rmse_m = icp.rmse_m;
  record.attempt.verdict.information = edge.information;
  poses_.AddRelocalization(std::move(record), edge);
}

void Backend::AfterRelocalization(int keyframe) {
  anchor_ = keyframe;
  ++counts_.relocalisations;
}

int Backend::BeginSubmap() {
  begins_submap_ = true;
  anchor_.reset();
  return poses_.submap_count();
}

void Backend::StartLoopTask() {
  in_task_ = waiting_.size();
  closer_->Start({std::move(waiting_), Graph(poses_.KeyframePoses()),
                  options_.enabled ? poses_.PieceOfKeyframe() : poses_.SubmapOfKeyframe()});
  waiting_.clear();
}

Relocalization Backend::Find(const ColoredView& view, int rank) {
  if (real_time_ && closer_->task().IsAtWork()) return {};
  return closer_->Find(view, rank, poses_.KeyframePoses());
}

GlobalRegistrationResult Backend::RegisterTo(const ColoredView& earlier,
                                             const ColoredView& view) const {
  return closer_->RegisterTo(earlier, view);
}

void Backend::StartCalibration() {
  CalibrationRecord record;
  record.keyframes = poses_.keyframes().size();
  record.begun_frame = poses_.frames().back().index;
  calibrations_.push_back(record);
  std::vector<Rigid3d> keyframes = poses_.KeyframePoses();
  Trajectory trajectory = poses_.trajectory();
  KeepPiecesApart(poses_, &keyframes, &trajectory);
  calibrator_->StartTask(std::move(keyframes), std::move(trajectory));
}

void Backend::EndCalibration() {
  if (!calibrator_) return;
  if (calibrator_->task().IsPending()) calibrations_.pop_back();
  calibrator_->End();
}

std::vector<WorldCorrection> Backend::Finish() {
  std::vector<WorldCorrection> corrections;
  FinishLoops(&corrections);
  if (calibrator_ && calibrator_->task().IsPending()) TakeCalibration(&corrections);
  FusePriorMotions(&corrections);
  return corrections;
}

std::optional<WorldCorrection> Backend::PlacePieces(const std::vector<Eigen::AlignedBox3d>& boxes) {
  constexpr double kGap_m = 1;
  const std::vector<int> piece_of_keyframe = poses_.PieceOfKeyframe();
  const std::size_t pieces = 1 + poses_.CountDisconnectedSubmaps();
  if (pieces == 1) return std::nullopt;
  std::vector<Eigen::AlignedBox3d> box_of_piece(pieces);
  for (std::size_t k = 0; k < piece_of_keyframe.size(); ++k) {
    Eigen::AlignedBox3d& box = box_of_piece[piece_of_keyframe[k]];
    box.extend(boxes[poses_.keyframes()[k].submap]);
    box.extend(poses_.FrameOf(static_cast<int>(k)).world_from_camera.translation);
  }
  std::vector<Rigid3d> move_of_piece(pieces);
  double end_m = box_of_piece[0].max().x();
  for (std::size_t p = 1; p < pieces; ++p) {
    const double shift_m = std::max(0., end_m + kGap_m - box_of_piece[p].min().x());
    move_of_piece[p].translation.x() = shift_m;
    end_m = box_of_piece[p].max().x() + shift_m;
  }
  std::vector<Rigid3d> of_keyframes;
  for (const int piece : piece_of_keyframe) of_keyframes.push_back(move_of_piece[piece]);
  WorldCorrection correction = Move(of_keyframes);
  correction.piece_of_submap.assign(boxes.size(), 0);
  return correction;
}

void Backend::FinishLoops(std::vector<WorldCorrection>* corrections) {
  while (closer_ && (closer_->task().IsPending() || !waiting_.empty())) {
    if (!closer_->task().IsPending()) StartLoopTask();
    TakeLoops(corrections);
  }
}

// Applies the calibration result on top of all corrections since the task started. No loop task may
// be running.
void Backend::TakeCalibration(std::vector<WorldCorrection>* corrections) {
  const DepthCalibration from = calibrator_->calibration();
  Calibrator::Outcome outcome = calibrator_->Take();
  CalibrationRecord& record = calibrations_.back();
  record.frame = poses_.frames().back().index;
  record.summary = std::move(outcome.summary);
  record.color_latency = outcome.color_latency;
  const DepthCalibration& to = calibrator_->calibration();
  if (AreSame(from, to)) return;
  const std::vector<Rigid3d> before = poses_.KeyframePoses();
  std::vector<Rigid3d> after;
  for (std::size_t k = 0; k < outcome.world_from_keyframe.size(); ++k) {
    after.push_back(before[k] * outcome.world_from_keyframe_before[k].Inverse() *
                    outcome.world_from_keyframe[k]);
  }
  Recalibration recalibration = {from, to, PosesOfIndices(poses_.frames())};
  WorldCorrection correction = Move(CorrectionsOfKeyframes(after));
  correction.recalibration = std::move(recalibration);
  poses_.RecalibrateEdges(before);
  if (closer_) closer_->UseCalibration(to);
  corrections->push_back(std::move(correction));
}

void Backend::TakeLoops(std::vector<WorldCorrection>* corrections) {
  LoopOutcome outcome = closer_->task().Take();
  in_task_ = 0;
  counts_.removed_views += outcome.removed_views;
  const std::size_t loops_before = poses_.loops().size();
  for (LoopRecord& attempt : outcome.attempts) {
    std::optional<PoseGraphEdge> edge;
    if (attempt.attempt.verdict.accepted()) edge = LoopEdge(attempt.attempt, options_.noise);
    poses_.AddLoop(std::move(attempt), edge);
  }
  if (!outcome.optimised) return;
  poses_.SetLoopsInGraph(outcome.loops_in_graph);
  const std::vector<Rigid3d> of_keyframes = CorrectionsOfKeyframes(outcome.world_from_keyframe);
  double most = 0;
  for (std::size_t k = 0; k < of_keyframes.size(); ++k) {
    const PosedFrame& frame = poses_.FrameOf(static_cast<int>(k));
    most = std::max(most, Displacement(of_keyframes[k], frame.world_from_camera.translation));
  }
  WorldCorrection correction;
  constexpr double kMinCorrection_m = 0.002;  // smaller corrections do not move the map
  if (most > kMinCorrection_m) correction = Move(of_keyframes);
  for (std::size_t i = loops_before; i < poses_.loops().size(); ++i) {
    if (poses_.loops()[i].in_graph) correction.joined.push_back(poses_.loops()[i].target_frame);
  }
  correction.piece_of_submap = poses_.PieceOfSubmap();
  if (correction.moves || !correction.joined.empty()) corrections->push_back(std::move(correction));
}

WorldCorrection Backend::Move(const std::vector<Rigid3d>& new_from_old_of_keyframe) {
  WorldCorrection correction;
  correction.moves = true;
  correction.corrections =
      CorrectionsOfFrames(poses_.frames(), poses_.frame_of_keyframe(), new_from_old_of_keyframe);
  correction.new_from_old_now = correction.corrections.At(poses_.frames().back().index);
  poses_.Move(correction.corrections);
  ++counts_.corrections;
  return correction;
}

// Corrections of all keyframes. Keyframes that were added after the task started move with their
// parents.
std::vector<Rigid3d> Backend::CorrectionsOfKeyframes(
    const std::vector<Rigid3d>& world_from_keyframe) const {
  std::vector<Rigid3d> corrections;
  for (std::size_t k = 0; k < poses_.keyframes().size(); ++k) {
    const int keyframe = static_cast<int>(k), parent = poses_.ParentOf(keyframe);
    const Rigid3d& old_pose = poses_.FrameOf(keyframe).world_from_camera;
    corrections.push_back(k < world_from_keyframe.size()
                              ? world_from_keyframe[k] * old_pose.Inverse()
                          : parent == KeyframeLink::kNone ? Rigid3d()
                                                          : corrections[parent]);
  }
  return corrections;
}

std::vector<Keyframe> Backend::keyframe_views() const {
  std::vector<Keyframe> keyframes = closer_->keyframes();
  for (std::size_t k = 0; k < keyframes.size(); ++k) {
    keyframes[k].world_from_camera = poses_.FrameOf(static_cast<int>(k)).world_from_camera;
  }
  return keyframes;
}

std::size_t Backend::settled_keyframes() const {
  return poses_.keyframes().size() - waiting_.size() - in_task_;
}

InverseDepthField Backend::Field() const {
  return calibrator_ ? calibrator_->calibration().field : InverseDepthField();
}

const DepthCalibration* Backend::calibration() const {
  return calibrator_ ? &calibrator_->calibration() : nullptr;
}

double Backend::color_latency_s() const { return calibrator_ ? calibrator_->color_latency_s() : 0; }

bool Backend::is_calibrating() const { return calibrator_ && calibrator_->IsCalibrating(); }

bool Backend::is_recalibrated() const { return calibrator_ && !calibrator_->IsAsGiven(); }

BackendCounts Backend::counts() const {
  const std::vector<LoopRecord>& loops = poses_.loops();
  BackendCounts counts = counts_;
  counts.keyframes = poses_.keyframes().size();
  counts.loop_candidates = loops.size();
  counts.loops_accepted = std::count_if(loops.begin(), loops.end(),
                                        [](const LoopRecord& loop) { return loop.in_graph; });
  counts.loops_rejected = counts.loop_candidates - counts.loops_accepted;
  counts.submaps = static_cast<std::size_t>(poses_.submap_count());
  counts.disconnected_submaps = poses_.CountDisconnectedSubmaps();
  return counts;
}

}  // namespace surfit
