#include "run/sequence_slam.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <optional>
#include <utility>

#include "run/posed_views.h"
#include "run/results/tracking_dump.h"
#include "surfit/core/error.h"

namespace surfit {
namespace {

std::string DumpFolder(const std::string& folder, int frame) {
  std::array<char, 30> name;
  std::snprintf(name.data(), name.size(), "/frame-%06d", frame);
  return folder + name.data();
}

}  // namespace

SequenceSlam::SequenceSlam(const SlamRunOptions& options, const SequenceInfo& info,
                           KeptSession* session, std::function<void(const FrameReport&)> on_pose)
    : options_(options), info_(info), session_(session), on_pose_(std::move(on_pose)) {
  if (options.poses == "groundtruth" && info.ground_truth.empty()) {
    throw InputError(
        Concat("poses is 'groundtruth', but ", options.sequence.path, " has no ground truth"));
  }
}

void SequenceSlam::Begin(double stamp_s) {
  if (session_ && session_->has_state()) {
    slam_ = session_->MakeSlam(info_);
  } else {
    slam_ = std::make_unique<Slam>(info_.sensor(), options_.slam,
                                   InitialPose(options_.initial_pose, info_, stamp_s));
  }
  if (session_) session_->Begin(info_, slam_.get());
  slam_->OnPose(on_pose_);
  if (options_.dump_failures.empty()) return;
  slam_->OnLostFrame([this](const LostFrame& lost) {
    WriteTrackingDump(lost, options_.slam, DumpFolder(options_.dump_failures, lost.index));
  });
}

FrameReport SequenceSlam::Process(const RgbdFrame& frame) {
  if (!slam_) Begin(frame.stamp_s);
  FrameReport report = options_.poses == "track" ? slam_->Process(frame) : ProcessAtTruePose(frame);
  if (report.confirmed) {
    trajectory_.push_back({report.confirmed->stamp_s, report.confirmed->world_from_camera});
    frames_.push_back(report.confirmed->index);
  }
  if (report.state != FrameState::kLost) {
    trajectory_.push_back({report.stamp_s, report.world_from_camera});
    frames_.push_back(report.index);
  }
  if (session_) session_->Offer(*slam_, report.stamp_s);
  return report;
}

FrameReport SequenceSlam::ProcessAtTruePose(const RgbdFrame& frame) {
  const std::optional<Rigid3d> pose = InterpolatePose(info_.ground_truth, frame.stamp_s);
  if (pose) return slam_->ProcessAt(frame, *pose);
  without_pose_.Tell(Concat("frame ", frame.index, " has no true pose within reach: not fused"));
  FrameReport report;
  report.index = frame.index;
  report.stamp_s = frame.stamp_s;
  return report;
}

void SequenceSlam::Finish() {
  slam_->Finish();
  const Backend* backend = slam_->backend();
  if (!backend) return;
  TakeTrajectory();
  TakeFoundSensor();
  if (session_) session_->Finish(*slam_);
}

// Of this run's frames, as they were corrected; those of a camera that was only localised were not.
void SequenceSlam::TakeTrajectory() {
  if (session_ && session_->is_localized()) return;
  const int first = session_ ? session_->first_index() : 0;
  trajectory_.clear();
  for (const PosedFrame& frame : slam_->backend()->poses().frames()) {
    if (frame.index >= first) trajectory_.push_back({frame.stamp_s, frame.world_from_camera});
  }
}

// The backend may have the frame already that SLAM has ended in.
void SequenceSlam::FinishEarly() {
  if (!slam_->backend()) return;
  TakeTrajectory();
  const std::size_t count = std::min(trajectory_.size(), frames_.size());
  trajectory_.resize(count);
  frames_.resize(count);
  TakeFoundSensor();
}

void SequenceSlam::TakeFoundSensor() {
  const Backend& backend = *slam_->backend();
  if (backend.is_recalibrated()) found_.calibration = *backend.calibration();
  found_.color_latency_s = backend.color_latency_s();
}

void SequenceSlam::Improve(RefinedSequence refined) {
  trajectory_ = std::move(refined.trajectory);
  found_ = refined.found;
}

}  // namespace surfit
