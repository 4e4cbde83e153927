#include "finishing/final_refinement.h"

#include <algorithm>
#include <vector>

#include "core/trace.h"
#include "optimization/refinement/subsampled.h"
#include "surfit/frame/frame_source.h"
#include "surfit/optimization/keyframes.h"

namespace surfit {
namespace {

constexpr int kRefinementColumns = 320;
constexpr int kCellsAcross = 60;
constexpr double kTranslation_m = 0.05, kRotation_rad = 0.075;
constexpr std::size_t kMaxKeyframes = 240;  // both thresholds grow until this holds

struct Interrupted {};

RefinementOptions FinalOptions(const DepthSensor& sensor) {
  RefinementOptions options;
  options.cells_across = kCellsAcross;
  options.min_relative_cost_change = 1e-3;
  options.prior.Complete(sensor.prior);
  return options;
}

int StrideOf(const PinholeCamera& camera, int downsample) {
  constexpr int kMaxDownsample = 16;
  return std::clamp(camera.width / kRefinementColumns, 1, std::max(1, kMaxDownsample / downsample));
}

struct Keyframes {
  std::vector<std::size_t> poses;
  std::vector<RefinementKeyframe> keyframes;
};

std::optional<Keyframes> ReadKeyframes(const PosedSequence& known,
                                       const std::atomic<bool>& interrupted, FrameSource* source) {
  const std::vector<std::size_t> chosen =
      ChooseKeyframes(known.trajectory, kTranslation_m, kRotation_rad, kMaxKeyframes);
  DepthSensor sensor = source->info().sensor();
  sensor.readout_s = known.found.Of(sensor).readout_s;
  Keyframes read;
  const bool all =
      ReadPosedFrames(known, source, interrupted, [&](std::size_t pose, const RgbdFrame& frame) {
        if (!std::binary_search(chosen.begin(), chosen.end(), pose)) return;
        read.poses.push_back(pose);
        read.keyframes.push_back(
            {known.trajectory[pose].world_from_camera,
             MakeKeyframeImages(frame, sensor, MotionAt(known.trajectory, frame.stamp_s),
                                known.slam.preprocess)});
      });
  if (!all) return std::nullopt;
  return read;
}

Trajectory Corrected(const Trajectory& trajectory, const Keyframes& refined) {
  std::vector<Rigid3d> poses;
  for (const RefinementKeyframe& keyframe : refined.keyframes) {
    poses.push_back(keyframe.world_from_camera);
  }
  return CorrectTrajectory(trajectory, refined.poses, poses);
}

bool Contradicts(const DepthSensor& given, const std::optional<DepthCalibration>& found) {
  return found && !CalibrationWarning(given, *found).empty();
}

}  // namespace

std::optional<RefinedSequence> RefinePosedSequence(
    const PosedSequence& known, const PinholeCamera& camera, const std::atomic<bool>& interrupted,
    const std::function<void(const RefinementRound&)>& progress) {
  const TraceSlice slice("refine");
  SequenceOptions sequence = known.sequence;
  const int stride = StrideOf(camera, sequence.rectify.downsample);
  sequence.rectify.downsample *= stride;
  const auto source = ReopenSequence(sequence);
  std::optional<Keyframes> read = ReadKeyframes(known, interrupted, source.get());
  if (!read) return std::nullopt;
  const DepthSensor sensor = source->info().sensor();
  const DepthCalibration given = {sensor.camera, {}, sensor.readout_s};
  const std::optional<DepthCalibration> start =
      known.found.calibration ? std::optional(Subsampled(*known.found.calibration, stride))
                              : std::nullopt;
  const auto tell = [&](const RefinementRound& round) {
    if (interrupted) throw Interrupted();
    progress(round);
  };
  const RefinementOptions options = FinalOptions(sensor);
  RefinedSequence refined;
  refined.keyframes = read->keyframes.size();
  refined.trajectory = known.trajectory;
  refined.found = known.found;
  try {
    refined.summary = Refine(options, given, start.value_or(given), &read->keyframes, tell);
  } catch (const Interrupted&) {
    return std::nullopt;
  }
  const bool is_new = refined.summary.Succeeded() && !refined.summary.calibration_kept;
  if (is_new) {
    refined.held_out_gain = HeldOutGain(options, given, start.value_or(given),
                                        refined.summary.calibration, read->keyframes);
  }
  refined.is_applied =
      refined.held_out_gain > refined.summary.calibration_limit &&
      (Contradicts(sensor, start) || !Contradicts(sensor, refined.summary.calibration));
  ScaleUp(camera, stride, &refined.summary);
  if (!refined.is_applied) return refined;
  refined.trajectory = Corrected(known.trajectory, *read);
  refined.found.calibration = refined.summary.calibration;
  return refined;
}

}  // namespace surfit
