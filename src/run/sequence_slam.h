#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "core/repeated_warning.h"
#include "finishing/final_refinement.h"
#include "run/kept_session.h"
#include "surfit/frame/frame_source.h"
#include "surfit/geometry/trajectory.h"
#include "surfit/run/slam_run.h"

namespace surfit {

// SLAM over the frames of a sequence, as the options of a run say, and the trajectory that it
// estimates.
class SequenceSlam {
 public:
  // All must outlive it; without a session that is null. Calls on_pose as Slam::OnPose() says.
  // Throws InputError if the options ask for true poses that the sequence lacks.
  SequenceSlam(const SlamRunOptions& options, const SequenceInfo& info, KeptSession* session,
               std::function<void(const FrameReport&)> on_pose);

  // False until the first frame: its stamp may tell the pose to begin at.
  bool HasBegun() const { return slam_ != nullptr; }
  FrameReport Process(const RgbdFrame& frame);
  // Slam::SetMapPeriod(); the first frame is fused in any case.
  void SetMapPeriod(int frames) {
    if (slam_) slam_->SetMapPeriod(frames);
  }
  // Takes in the last loops, and corrects the trajectory by all of them.
  void Finish();
  // The trajectory of the frames so far, as it is, where SLAM has ended within a frame.
  void FinishEarly();
  // In the end: what is known better by now.
  void Improve(RefinedSequence refined);

  const SequenceInfo& info() const { return info_; }
  const SurfelMap& map() const { return slam_->map(); }
  const Slam& slam() const { return *slam_; }
  const Trajectory& trajectory() const { return trajectory_; }
  // The indices of the frames whose poses the trajectory has.
  const std::vector<int>& frames() const { return frames_; }
  // Of the frames as they are read, in the end.
  const FoundSensor& found() const { return found_; }

 private:
  void Begin(double stamp_s);
  void TakeTrajectory();
  void TakeFoundSensor();
  FrameReport ProcessAtTruePose(const RgbdFrame& frame);

  const SlamRunOptions& options_;
  const SequenceInfo& info_;
  KeptSession* const session_;
  const std::function<void(const FrameReport&)> on_pose_;
  std::unique_ptr<Slam> slam_;
  Trajectory trajectory_;
  std::vector<int> frames_;
  FoundSensor found_;
  RepeatedWarning without_pose_{"frames without a true pose"};
};

}  // namespace surfit
