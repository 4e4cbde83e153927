#include "surfit/slam/backend.h"

#include <algorithm>
#include <utility>

#include "slam/calibrator.h"
#include "slam/correct_frames.h"
#include "slam/edge_information.h"
#include "slam/keyframe_view.h"
#include "slam/loop_closer.h"
#include "surfit/core/options.h"

namespace surfit {
namespace {

const LoopOptions& Validated(const LoopOptions& options) {
  Validate(options);
  return options;
}

// How far a correction moves a camera and what it sees, at about 2 m.
double Displacement(const Rigid3d& new_from_old, const Eigen::Vector3d& camera) {
  constexpr double kDistanceM = 2;
  return (new_from_old * camera - camera).norm() +
         kDistanceM * RotationAngle(new_from_old.rotation);
}

}  // namespace

Backend::Backend(const DepthSensor& sensor, const PreprocessOptions& preprocess,
                 const LoopOptions& loops, const CalibrationOptions& calibration, LoopFinder finder,
                 bool real_time)
    : options_(Validated(loops)), real_time_(real_time) {
  if (loops.enabled) closer_ = std::make_unique<LoopCloser>(loops, std::move(finder), real_time);
  if (calibration.enabled) {
    calibrator_ = std::make_unique<Calibrator>(sensor, preprocess, calibration, real_time);
  }
}

Backend::~Backend() = default;

// Both count their frames; what is found of the camera is applied to a world at rest.
std::vector<WorldCorrection> Backend::BeginFrame() {
  const auto is_due = [&](auto* task) {
    return real_time_ ? task->IsThereAfterStep() : task->IsDueAfterStep();
  };
  const bool are_loops_due = closer_ && is_due(&closer_->task());
  const bool is_calibration_due = calibrator_ && is_due(&calibrator_->task());
  std::vector<WorldCorrection> corrections;
  if (are_loops_due) {
    counts_.waits += closer_->task().IsAtWork();
    TakeLoops(&corrections);
    StartTaskIfFree();
  }
  if (is_calibration_due && !(real_time_ && closer_ && closer_->task().IsUnderWay())) {
    counts_.waits += calibrator_->task().IsAtWork();
    if (!real_time_) FinishLoops(&corrections);
    TakeCalibration(&corrections);
    StartTaskIfFree();
  }
  return corrections;
}

// In real time none begins before what has been found of the camera is applied.
void Backend::StartTaskIfFree() {
  if (!closer_ || waiting_.empty() || closer_->task().IsUnderWay()) return;
  if (real_time_ && calibrator_ && calibrator_->task().IsThere()) return;
  StartTask();
}

void Backend::AddFrame(const RgbdFrame& frame, const Rigid3d& world_from_camera,
                       const IcpResult& icp, const FramePyramid& pyramid) {
  if (begins_submap_) ++submap_;
  if (begins_submap_ || anchor_) ++stretch_;
  PosedFrame posed = {frame.index, frame.stamp_s, world_from_camera, 0, stretch_};
  const bool is_keyframe = begins_submap_ || anchor_ || BecomesKeyframe(posed, pyramid);
  posed.keyframe = static_cast<int>(frame_of_keyframe_.size()) - (is_keyframe ? 0 : 1);
  frames_.push_back(posed);
  if (is_keyframe) AddKeyframe(frame, icp, pyramid);
}

void Backend::AddFrozenFrame(int index, double stamp_s) {
  PosedFrame frame = frames_.back();
  frame.index = index;
  frame.stamp_s = stamp_s;
  frames_.push_back(frame);
}

bool Backend::BecomesKeyframe(const PosedFrame& frame, const FramePyramid& pyramid) const {
  return IsKeyframe(*last_keyframe_, frame.index, pyramid.levels.front(), frame.world_from_camera,
                    options_.keyframes);
}

// Of the frame added last.
void Backend::AddKeyframe(const RgbdFrame& frame, const IcpResult& icp,
                          const FramePyramid& pyramid) {
  const PosedFrame& posed = frames_.back();
  const int parent = begins_submap_ ? KeyframeLink::kNone
                     : anchor_      ? *anchor_
                                    : static_cast<int>(parent_of_keyframe_.size()) - 1;
  const std::optional<PoseGraphEdge> edge = EdgeTo(posed, parent, icp);
  last_keyframe_ = {posed.index, posed.stamp_s, posed.world_from_camera,
                    MakePlaceView(pyramid, {}, options_.views)};  // its depth alone
  parent_of_keyframe_.push_back(parent);
  submap_of_keyframe_.push_back(parent == KeyframeLink::kNone ? submap_
                                                              : submap_of_keyframe_[parent]);
  frame_of_keyframe_.push_back(static_cast<int>(frames_.size()) - 1);
  begins_submap_ = false;
  anchor_.reset();
  if (calibrator_) calibrator_->AddKeyframe(frame);
  if (edge) edges_.push_back(*edge);
  if (closer_) {
    NewKeyframe added;
    added.keyframe.frame_index = posed.index;
    added.keyframe.stamp_s = posed.stamp_s;
    added.keyframe.world_from_camera = posed.world_from_camera;
    added.view = ViewOf({pyramid, frame.color}, options_.views);
    if (edge) added.edges.push_back(*edge);
    if (on_keyframe_) {
      on_keyframe_(posed.index, added.view, calibrator_ ? calibrator_->last_keyframe() : nullptr);
    }
    waiting_.push_back(std::move(added));
    StartTaskIfFree();
  }
  if (calibrator_ && calibrator_->IsTaskDue()) StartCalibration();
}

// Of the pose graph, from the keyframe's parent.
std::optional<PoseGraphEdge> Backend::EdgeTo(const PosedFrame& keyframe, int parent,
                                             const IcpResult& icp) const {
  if (parent == KeyframeLink::kNone) return std::nullopt;
  const PosedFrame& from = frames_[frame_of_keyframe_[parent]];
  PoseGraphEdge edge;
  edge.a = static_cast<std::size_t>(parent);
  edge.b = static_cast<std::size_t>(keyframe.keyframe);
  edge.a_from_b = from.world_from_camera.Inverse() * keyframe.world_from_camera;
  edge.information = anchor_ ? LoopInformation(icp.information, options_.noise)
                             : OdometryInformation(icp, keyframe.index - from.index, edge.a_from_b,
                                                   options_.noise);
  return edge;
}

void Backend::AfterRelocalization(int keyframe) {
  anchor_ = keyframe;
  ++counts_.relocalisations;
}

Rigid3d Backend::BeginSubmap(const Rigid3d& world_from_last) {
  begins_submap_ = true;
  const double beside = kSubmapDistance * (submap_ + 1);
  return {world_from_last.rotation, Eigen::Vector3d(beside, 0, 0)};
}

std::vector<Rigid3d> Backend::KeyframePoses() const {
  std::vector<Rigid3d> poses;
  for (const int frame : frame_of_keyframe_) poses.push_back(frames_[frame].world_from_camera);
  return poses;
}

void Backend::StartTask() {
  in_task_ = waiting_.size();
  closer_->Start({std::move(waiting_), KeyframePoses()});
  waiting_.clear();
}

Relocalization Backend::Find(const ColoredView& view) {
  return closer_->Find(view, KeyframePoses());
}

void Backend::StartCalibration() {
  CalibrationRecord record;
  record.keyframes = frame_of_keyframe_.size();
  record.begun_frame = frames_.back().index;
  calibrations_.push_back(record);
  calibrator_->StartTask(KeyframePoses(), trajectory());
}

void Backend::EndCalibration() {
  if (!calibrator_) return;
  if (calibrator_->task().IsUnderWay()) calibrations_.pop_back();
  calibrator_->End();
}

std::vector<WorldCorrection> Backend::Finish() {
  std::vector<WorldCorrection> corrections;
  FinishLoops(&corrections);
  if (calibrator_ && calibrator_->task().IsUnderWay()) TakeCalibration(&corrections);
  return corrections;
}

void Backend::FinishLoops(std::vector<WorldCorrection>* corrections) {
  while (closer_ && (closer_->task().IsUnderWay() || !waiting_.empty())) {
    if (!closer_->task().IsUnderWay()) StartTask();
    TakeLoops(corrections);
  }
}

// No loops may be under way. What has been corrected since the task was begun stays so.
void Backend::TakeCalibration(std::vector<WorldCorrection>* corrections) {
  const DepthCalibration from = calibrator_->calibration();
  Calibrator::Outcome outcome = calibrator_->Take();
  CalibrationRecord& record = calibrations_.back();
  record.frame = frames_.back().index;
  record.summary = std::move(outcome.summary);
  record.color_latency = outcome.color_latency;
  const DepthCalibration& to = calibrator_->calibration();
  if (AreSame(from, to)) return;
  const std::vector<Rigid3d> before = KeyframePoses();
  std::vector<Rigid3d> after;
  for (std::size_t k = 0; k < outcome.world_from_keyframe.size(); ++k) {
    after.push_back(before[k] * outcome.world_from_keyframe_before[k].Inverse() *
                    outcome.world_from_keyframe[k]);
  }
  Recalibration recalibration = {from, to, PosesOfIndices(frames_)};
  WorldCorrection correction = Move(CorrectionsOfKeyframes(after));
  correction.recalibration = std::move(recalibration);
  if (closer_) closer_->Recalibrate(before, KeyframePoses());
  for (NewKeyframe& added : waiting_) {
    surfit::Recalibrate(before, KeyframePoses(), &added.edges);
  }
  surfit::Recalibrate(before, KeyframePoses(), &edges_);
  corrections->push_back(std::move(correction));
}

void Backend::TakeLoops(std::vector<WorldCorrection>* corrections) {
  const LoopOutcome outcome = closer_->task().Take();
  UpdateLoops(outcome);
  if (!outcome.optimised) return;
  const std::vector<Rigid3d> of_keyframes = CorrectionsOfKeyframes(outcome.world_from_keyframe);
  double most = 0;
  for (std::size_t k = 0; k < of_keyframes.size(); ++k) {
    most =
        std::max(most, Displacement(of_keyframes[k],
                                    frames_[frame_of_keyframe_[k]].world_from_camera.translation));
  }
  WorldCorrection correction;
  if (most > options_.min_correction_m) correction = Move(of_keyframes);
  correction.joined = NewlyJoined(outcome);
  if (correction.moves || !correction.joined.empty()) corrections->push_back(std::move(correction));
}

WorldCorrection Backend::Move(const std::vector<Rigid3d>& new_from_old_of_keyframe) {
  WorldCorrection correction;
  correction.moves = true;
  correction.corrections =
      CorrectionsOfFrames(frames_, frame_of_keyframe_, new_from_old_of_keyframe);
  correction.new_from_old_now = correction.corrections.At(frames_.back().index);
  for (PosedFrame& frame : frames_) {
    frame.world_from_camera = correction.corrections.At(frame.index) * frame.world_from_camera;
  }
  last_keyframe_->world_from_camera = frames_[frame_of_keyframe_.back()].world_from_camera;
  ++counts_.corrections;
  return correction;
}

void Backend::UpdateLoops(const LoopOutcome& outcome) {
  in_task_ = 0;
  for (const LoopRecord& record : outcome.attempts) {
    if (record.attempt.verdict.accepted()) {
      edges_.push_back(LoopEdge(record.attempt, options_.noise));
    }
  }
  counts_.given_up_views += outcome.given_up_views;
  loops_.insert(loops_.end(), outcome.attempts.begin(), outcome.attempts.end());
  if (!outcome.optimised) return;
  std::size_t loop = 0;
  for (LoopRecord& record : loops_) {
    if (record.attempt.verdict.accepted()) record.in_graph = outcome.loops_in_graph[loop++];
  }
}

// Of the loops that came last.
std::vector<int> Backend::NewlyJoined(const LoopOutcome& outcome) const {
  std::vector<int> joined;
  for (std::size_t i = loops_.size() - outcome.attempts.size(); i < loops_.size(); ++i) {
    if (loops_[i].in_graph) joined.push_back(loops_[i].target_frame);
  }
  return joined;
}

// Keyframes that came after the task was begun move with the one that they hang on.
std::vector<Rigid3d> Backend::CorrectionsOfKeyframes(
    const std::vector<Rigid3d>& world_from_keyframe) const {
  std::vector<Rigid3d> corrections;
  for (std::size_t k = 0; k < frame_of_keyframe_.size(); ++k) {
    const int parent = parent_of_keyframe_[k];
    const Rigid3d& old_pose = frames_[frame_of_keyframe_[k]].world_from_camera;
    corrections.push_back(k < world_from_keyframe.size()
                              ? world_from_keyframe[k] * old_pose.Inverse()
                          : parent == KeyframeLink::kNone ? Rigid3d()
                                                          : corrections[parent]);
  }
  return corrections;
}

std::vector<KeyframeLink> Backend::keyframes() const {
  std::vector<KeyframeLink> links;
  for (std::size_t k = 0; k < frame_of_keyframe_.size(); ++k) {
    const int parent = parent_of_keyframe_[k];
    links.push_back({FrameOfKeyframe(static_cast<int>(k)),
                     parent == KeyframeLink::kNone ? KeyframeLink::kNone : FrameOfKeyframe(parent),
                     submap_of_keyframe_[k]});
  }
  return links;
}

std::vector<Keyframe> Backend::keyframe_views() const {
  std::vector<Keyframe> keyframes = closer_->keyframes();
  const std::vector<Rigid3d> poses = KeyframePoses();
  for (std::size_t k = 0; k < keyframes.size(); ++k) keyframes[k].world_from_camera = poses[k];
  return keyframes;
}

std::vector<bool> Backend::loops_in_graph() const {
  std::vector<bool> in_graph;
  for (const LoopRecord& loop : loops_) {
    if (loop.attempt.verdict.accepted()) in_graph.push_back(loop.in_graph);
  }
  return in_graph;
}

std::size_t Backend::settled_keyframes() const {
  return frame_of_keyframe_.size() - waiting_.size() - in_task_;
}

const DepthCalibration* Backend::calibration() const {
  return calibrator_ ? &calibrator_->calibration() : nullptr;
}

double Backend::color_latency_s() const { return calibrator_ ? calibrator_->color_latency_s() : 0; }

bool Backend::is_calibrating() const { return calibrator_ && calibrator_->IsCalibrating(); }

bool Backend::is_recalibrated() const { return calibrator_ && !calibrator_->IsAsGiven(); }

BackendCounts Backend::counts() const {
  BackendCounts counts = counts_;
  counts.keyframes = frame_of_keyframe_.size();
  counts.loops_proposed = loops_.size();
  counts.loops_accepted = std::count_if(loops_.begin(), loops_.end(),
                                        [](const LoopRecord& loop) { return loop.in_graph; });
  counts.loops_refused = counts.loops_proposed - counts.loops_accepted;
  counts.submaps = static_cast<std::size_t>(submap_) + 1;
  counts.submaps_apart = SubmapsApart();
  return counts;
}

Trajectory Backend::trajectory() const {
  Trajectory trajectory;
  for (const PosedFrame& frame : frames_) {
    trajectory.push_back({frame.stamp_s, frame.world_from_camera});
  }
  return trajectory;
}

// Joins the submaps of each loop, until no more come to the first.
std::size_t Backend::SubmapsApart() const {
  const auto submap_at = [&](int frame_index) {
    const auto at =
        std::lower_bound(frames_.begin(), frames_.end(), frame_index,
                         [](const PosedFrame& frame, int index) { return frame.index < index; });
    return submap_of_keyframe_[at->keyframe];
  };
  std::vector<bool> joined(static_cast<std::size_t>(submap_ + 1), false);
  if (!joined.empty()) joined[0] = true;
  for (std::size_t pass = 0; pass < joined.size(); ++pass) {
    for (const LoopRecord& loop : loops_) {
      if (!loop.in_graph) continue;
      const int a = submap_at(loop.source_frame), b = submap_at(loop.target_frame);
      if (joined[a] || joined[b]) joined[a] = joined[b] = true;
    }
  }
  return static_cast<std::size_t>(std::count(joined.begin(), joined.end(), false));
}

}  // namespace surfit
