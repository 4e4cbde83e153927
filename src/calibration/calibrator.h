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

// Calibrates the depth camera from all keyframes so far, in background tasks.
class Calibrator {
 public:
  struct Outcome {
    RefinementSummary summary;
    ColorLatency color_latency;
    std::vector<Rigid3d> world_from_keyframe_before, world_from_keyframe;
  };

  // `sensor` is the input sensor. If `always_in_background`, tasks run in a BackgroundTask with any
  // number of threads.
  Calibrator(const DepthSensor& sensor, const PreprocessOptions& preprocess,
             const CalibrationOptions& options, bool always_in_background);

  using Frames = std::vector<std::shared_ptr<const RgbdFrame>>;
  // Continues from a saved calibration and its keyframes. Without keyframes, the calibration does
  // not change any more.
  void ContinueFrom(const std::optional<DepthCalibration>& calibration, double color_latency_s,
                    Frames frames);

  const DepthCalibration& calibration() const { return calibration_; }
  bool IsAsGiven() const { return AreSame(calibration_, given_); }
  // Estimated colour latency in addition to RgbdCamera::color_latency_s, s.
  double color_latency_s() const { return color_latency_s_; }

  // Adds a keyframe with measured images. They are copied.
  void AddKeyframe(const RgbdFrame& frame);
  // Last stored keyframe; null if calibration needs no more keyframes.
  std::shared_ptr<const RgbdFrame> last_keyframe() const {
    return frames_.empty() ? nullptr : frames_.back();
  }
  // Returns whether a task is running or another one can start.
  bool IsCalibrating() const { return next_count_ > 0 || task_.IsPending(); }
  // Returns whether there are enough keyframes for the next task, and no task is running.
  bool IsTaskDue() const {
    return !task_.IsPending() && next_count_ > 0 && frames_.size() >= next_count_;
  }
  // Starts a task with the poses of all keyframes so far. `trajectory` has all frames, for the
  // motion during their readout.
  void StartTask(std::vector<Rigid3d> world_from_keyframe, const Trajectory& trajectory);

  BackgroundTask<Outcome>& task() { return task_; }
  // Returns the result of the task, and makes it the current calibration.
  Outcome Take();

  // Drops the task and starts no other task.
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
  std::size_t next_count_;        // number of keyframes for the next task; 0: no further task
  BackgroundTask<Outcome> task_;  // last member: its destructor waits for the task
};

}  // namespace surfit
