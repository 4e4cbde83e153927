#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/spare_time.h"
#include "surfit/calibration/calibration.h"
#include "surfit/frame/camera_motion.h"
#include "surfit/frame/preprocess.h"
#include "surfit/frame/rgbd_frame.h"
#include "surfit/geometry/trajectory.h"
#include "surfit/optimization/color_latency.h"
#include "surfit/optimization/refine.h"

namespace surfit {

// Calibrates the depth camera by the keyframes so far, beside tracking.
class Calibrator {
 public:
  struct Outcome {
    RefinementSummary summary;
    ColorLatency color_latency;
    std::vector<Rigid3d> world_from_keyframe_before, world_from_keyframe;
  };

  // The sensor as given; where `always_beside`, tasks are SpareTimeTask's.
  Calibrator(const DepthSensor& sensor, const PreprocessOptions& preprocess,
             const CalibrationOptions& options, bool always_beside);

  using Frames = std::vector<std::shared_ptr<const RgbdFrame>>;
  // Takes up what another one has found by these keyframes; without them that is the last word.
  void GoOnFrom(const std::optional<DepthCalibration>& calibration, double color_latency_s,
                Frames frames);

  // What frames are to be seen by.
  const DepthCalibration& calibration() const { return calibration_; }
  bool IsAsGiven() const { return AreSame(calibration_, given_); }
  // By how much colour is earlier than frames have it.
  double color_latency_s() const { return color_latency_s_; }

  // A keyframe as it was measured; frames are copied.
  void AddKeyframe(const RgbdFrame& frame);
  // That keyframe as it is kept; null where none are kept any more.
  std::shared_ptr<const RgbdFrame> last_keyframe() const {
    return frames_.empty() ? nullptr : frames_.back();
  }
  // Another task may come, or is under way.
  bool IsCalibrating() const { return next_count_ > 0 || task_.IsUnderWay(); }
  // There are as many keyframes as a task waits for, and none is under way.
  bool IsTaskDue() const {
    return !task_.IsUnderWay() && next_count_ > 0 && frames_.size() >= next_count_;
  }
  // Begins it with the poses of all keyframes so far; trajectory has all frames, for the motion
  // during their readout.
  void StartTask(std::vector<Rigid3d> world_from_keyframe, const Trajectory& trajectory);

  SpareTimeTask<Outcome>& task() { return task_; }
  // Of the task; the calibration is then what it found.
  Outcome Take();

  // Gives up the task and begins no other.
  void End();

 private:
  Outcome Run(const Frames& frames, const std::vector<CameraMotion>& motions,
              std::vector<Rigid3d> world_from_keyframe, const DepthCalibration& start) const;
  ColorLatency LatencyOf(const Frames& frames, const std::vector<RefinementKeyframe>& keyframes,
                         const DepthCalibration& calibration) const;

  PinholeCamera camera_;  // as given
  DepthSensor sensor_;    // likewise, of the images that are kept
  PreprocessOptions preprocess_;
  CalibrationOptions options_;
  DepthCalibration given_, calibration_;
  double color_latency_s_ = 0;
  Frames frames_;                // keyframes, until no task needs them
  std::size_t next_count_;       // of keyframes, for the next task; 0 = there is none
  SpareTimeTask<Outcome> task_;  // last: it is waited for before the others go
};

}  // namespace surfit
