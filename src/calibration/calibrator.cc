#include "calibration/calibrator.h"

#include <algorithm>
#include <utility>

#include "core/trace.h"
#include "optimization/refinement/subsampled.h"
#include "surfit/optimization/keyframes.h"

namespace surfit {
namespace {

constexpr int kFrameStride = 2;

// Side of an image region with fully correlated model error, in cells.
constexpr int kSharedCells = 4;

// Number of additional keyframes before the next task.
std::size_t MoreKeyframes(std::size_t keyframes) { return std::max<std::size_t>(1, keyframes / 4); }

// Number of frames from the start of a task to the use of its result. On two cores at 30 Hz, a task
// needs about half of this time.
int DelayFrames(int keyframes) { return 1 + keyframes / 2 + keyframes * keyframes / 40; }

DepthSensor Subsampled(DepthSensor sensor) {
  sensor.camera = sensor.camera.Subsampled(kFrameStride);
  return sensor;
}

template <typename T>
Image<T> Subsampled(const Image<T>& image) {
  Image<T> few((image.width() + kFrameStride - 1) / kFrameStride,
               (image.height() + kFrameStride - 1) / kFrameStride);
  for (int v = 0; v < few.height(); ++v) {
    for (int u = 0; u < few.width(); ++u) few(u, v) = image(kFrameStride * u, kFrameStride * v);
  }
  return few;
}

}  // namespace

Calibrator::Calibrator(const DepthSensor& sensor, const PreprocessOptions& preprocess,
                       const CalibrationOptions& options, bool always_in_background)
    : camera_(sensor.camera),
      sensor_(Subsampled(sensor)),
      preprocess_(preprocess),
      options_(options),
      given_{sensor.camera, {}, sensor.readout_s},
      calibration_(given_),
      next_count_(options.first_keyframes),
      task_(always_in_background) {
  RefinementOptions& refinement = options_.refinement;
  refinement.prior.Complete(sensor.prior);
  const int cell_px = std::max(1, sensor_.camera.width / refinement.cells_across);
  refinement.correlation_px = std::max(refinement.correlation_px, kSharedCells * cell_px);
}

void Calibrator::ContinueFrom(const std::optional<DepthCalibration>& calibration,
                              double color_latency_s, Frames frames) {
  calibration_ = calibration.value_or(given_);
  color_latency_s_ = color_latency_s;
  frames_ = std::move(frames);
  if (frames_.empty()) return End();
  while (next_count_ <= frames_.size()) next_count_ += MoreKeyframes(next_count_);
  if (next_count_ > static_cast<std::size_t>(options_.max_keyframes)) End();
}

void Calibrator::AddKeyframe(const RgbdFrame& frame) {
  if (next_count_ == 0) return;
  auto kept = std::make_shared<RgbdFrame>();
  kept->index = frame.index;
  kept->stamp_s = frame.stamp_s;
  kept->color_stamp_s = frame.color_stamp_s;
  kept->depth_m = Subsampled(frame.depth_m);
  kept->color = Subsampled(frame.color);
  frames_.push_back(std::move(kept));
}

void Calibrator::StartTask(std::vector<Rigid3d> world_from_keyframe, const Trajectory& trajectory) {
  std::vector<CameraMotion> motions;
  for (const auto& frame : frames_) motions.push_back(MotionAt(trajectory, frame->stamp_s));
  next_count_ += MoreKeyframes(next_count_);
  Frames frames = frames_;
  if (next_count_ > static_cast<std::size_t>(options_.max_keyframes)) {
    next_count_ = 0;  // the last task owns the frames
    frames_.clear();
  }
  const int delay_frames = DelayFrames(static_cast<int>(frames.size()));
  task_.Start(delay_frames,
              [this, frames = std::move(frames), motions = std::move(motions),
               poses = std::move(world_from_keyframe), start = calibration_]() mutable {
                return Run(frames, motions, std::move(poses), start);
              });
}

Calibrator::Outcome Calibrator::Run(const Frames& frames, const std::vector<CameraMotion>& motions,
                                    std::vector<Rigid3d> world_from_keyframe,
                                    const DepthCalibration& start) const {
  const TraceSlice slice("calibrate");
  std::vector<RefinementKeyframe> keyframes;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    keyframes.push_back(
        {world_from_keyframe[k], MakeKeyframeImages(*frames[k], sensor_, motions[k], preprocess_)});
  }
  Outcome outcome;
  outcome.summary =
      Refine(options_.refinement, Subsampled(given_, kFrameStride), Subsampled(start, kFrameStride),
             &keyframes, [](const RefinementRound&) {});
  outcome.color_latency = LatencyOf(frames, keyframes, outcome.summary.calibration);
  ScaleUp(camera_, kFrameStride, &outcome.summary);
  outcome.world_from_keyframe_before = std::move(world_from_keyframe);
  for (const RefinementKeyframe& keyframe : keyframes) {
    outcome.world_from_keyframe.push_back(keyframe.world_from_camera);
  }
  return outcome;
}

ColorLatency Calibrator::LatencyOf(const Frames& frames,
                                   const std::vector<RefinementKeyframe>& keyframes,
                                   const DepthCalibration& calibration) const {
  std::vector<ColoredKeyframe> colored;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    if (frames[k]->color.empty()) continue;
    colored.push_back({keyframes[k], frames[k]->color_stamp_s - frames[k]->stamp_s});
  }
  return EstimateColorLatency(colored, calibration.camera, sensor_.prior.color_latency_s);
}

void Calibrator::End() {
  task_.Drop();
  next_count_ = 0;
  frames_.clear();
}

Calibrator::Outcome Calibrator::Take() {
  Outcome outcome = task_.Take();
  calibration_ = outcome.summary.calibration;
  color_latency_s_ = outcome.color_latency.latency_s;
  return outcome;
}

}  // namespace surfit
