#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/background_task.h"
#include "surfit/calibration/calibration.h"
#include "surfit/frame/camera_motion.h"
#include "surfit/frame/preprocess.h"
#include "surfit/frame/rgbd_frame.h"
#include "surfit/geometry/trajectory.h"
#include "surfit/optimization/color_latency.h"
#include "surfit/optimization/refine.h"

namespace surfit {

// Calibrates the depth camera and the colour latency in background tasks. Each task uses all
// keyframes so far, with every second column and row. Not thread-safe: one thread calls all
// functions. Call order: AddKeyframe(), then StartTask() if IsTaskDue(), then Take() when task() is
// due.
class Calibrator {
 public:
  // Result of a task. Both vectors have one world_from_camera per keyframe of the task: at its
  // start, and refined.
  struct Outcome {
    RefinementSummary summary;
    ColorLatency color_latency;
    std::vector<Rigid3d> world_from_keyframe_before, world_from_keyframe;
  };

  // `sensor` is the input sensor. If `always_in_background`, tasks have their own thread even if
  // one thread may compute.
  Calibrator(const DepthSensor& sensor, const PreprocessOptions& preprocess,
             const CalibrationOptions& options, bool always_in_background);

  using Frames = std::vector<std::shared_ptr<const RgbdFrame>>;
  // Continues from a saved calibration (std::nullopt: input calibration) and its subsampled
  // keyframes. Call before AddKeyframe(). An empty list of keyframes ends calibration.
  void ContinueFrom(const std::optional<DepthCalibration>& calibration, double color_latency_s,
                    Frames frames);

  const DepthCalibration& calibration() const { return calibration_; }
  // True if the calibration is equal to the input calibration.
  bool IsAsGiven() const { return AreSame(calibration_, given_); }
  // Estimated colour latency in addition to RgbdCamera::color_latency_s, s.
  double color_latency_s() const { return color_latency_s_; }

  // Adds a keyframe with measured images, whose subsampled images are copied. Does nothing after
  // the last task has started.
  void AddKeyframe(const RgbdFrame& frame);
  // Last subsampled keyframe. Null before the first keyframe, and after the last task has started.
  std::shared_ptr<const RgbdFrame> last_keyframe() const {
    return frames_.empty() ? nullptr : frames_.back();
  }
  // True if a task is pending (Take() not called), or if another task will follow.
  bool IsCalibrating() const { return next_count_ > 0 || task_.IsPending(); }
  // True if no task is pending and there are enough keyframes for the next task.
  bool IsTaskDue() const {
    return !task_.IsPending() && next_count_ > 0 && frames_.size() >= next_count_;
  }
  // Requires IsTaskDue(). `world_from_keyframe` has one pose per stored keyframe, which is not
  // checked: first of ContinueFrom(), then of AddKeyframe(). `trajectory` has all frames, for the
  // motion during readout.
  void StartTask(std::vector<Rigid3d> world_from_keyframe, const Trajectory& trajectory);

  BackgroundTask<Outcome>& task() { return task_; }
  // Waits for the task, returns its result, and makes its calibration the current one. Requires a
  // pending task. Throws the exception of the task.
  Outcome Take();

  // Ends calibration: waits for the running task and drops its result. The current calibration
  // stays.
  void End();

 private:
  Outcome Run(const Frames& frames, const std::vector<CameraMotion>& motions,
              std::vector<Rigid3d> world_from_keyframe, const DepthCalibration& start) const;
  ColorLatency LatencyOf(const Frames& frames, const std::vector<RefinementKeyframe>& keyframes,
                         const DepthCalibration& calibration) const;

  PinholeCamera camera_;  // input camera
  DepthSensor sensor_;    // input sensor for the subsampled images
  PreprocessOptions preprocess_;
  CalibrationOptions options_;
  DepthCalibration given_, calibration_;
  double color_latency_s_ = 0;
  Frames frames_;                 // stored keyframes; empty after the last task has started
  std::size_t next_count_;        // number of keyframes for the next task; 0: no next task
  BackgroundTask<Outcome> task_;  // last member: the destructor waits for the task
};

}  // namespace surfit
