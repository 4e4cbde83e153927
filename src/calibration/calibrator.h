#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/background_task.h"
#include "surfit/calibration/calibration.h"
#include "surfit/core/image.h"
#include "surfit/frame/camera_motion.h"
#include "surfit/frame/preprocess.h"
#include "surfit/frame/rgbd_frame.h"
#include "surfit/geometry/sensor.h"
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

// Depth noise that was measured in the first frames of a recording.
struct MeasuredNoise {
  // Number of frames for MeasureNoise().
  static constexpr int kFrames = 16;
  // Smaller noise is not distinguished from this value, 1/m: 4 mm at 2 m. Exact and smoothed depth
  // have smaller noise, but the errors of map and normals remain (ErrorModel::floor_sigma_m).
  static constexpr double kMinSigma = 0.001;
  // A starting value that differs by more than this factor is wrong. Estimates from different
  // frames of one real sensor differ by factors up to 1.6. Estimates of real sensors differ from
  // their presets by factors up to 2.
  static constexpr double kMaxRatio = 2.5;

  double inverse_depth_sigma = 0;  // DepthNoise, 1/m
  int pairs = 0;                   // number of compared pairs of frames
  std::int64_t samples = 0;        // number of compared pixels

  // Noise for SLAM: the measured noise, at least kMinSigma.
  DepthNoise Noise() const;
  // Returns true if Noise() and the starting value differ by more than kMaxRatio.
  bool Contradicts(const DepthNoise& start) const;
};

// Measures the noise of a depth sensor from the first frames, without a starting value. Each frame
// is registered to an earlier frame. A residual is the difference of the inverse depths of a point
// in both frames. Its variance is twice the variance of the noise. This is also true if
// neighbouring pixels have correlated noise, for example after smoothing. Residuals beyond three
// standard deviations are outliers: depth edges and moving objects.
//
// Errors that do not change with the motion are not measured: depth distortion and multipath. Pairs
// of frames with little motion are not used, because such errors can be constant in them. Images
// are depth in m. Images of another size than the camera are ignored. Returns std::nullopt unless
// two pairs of frames can be compared. The result does not depend on the number of threads.
std::optional<MeasuredNoise> MeasureNoise(const std::vector<Image<float>>& depths_m,
                                          const PinholeCamera& camera);

}  // namespace surfit
