#include "apps/doctor/check_recording.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "apps/doctor/recording_checks.h"
#include "calibration/calibrator.h"
#include "core/repeated_warning.h"
#include "finishing/posed_sequence.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/core/parallel.h"
#include "surfit/evaluation/trajectory_evaluation.h"
#include "surfit/slam/backend.h"
#include "surfit/slam/slam.h"

namespace surfit {
namespace {

constexpr int kSamples = 24;         // frames sampled for the check of the depth scale
constexpr double kFitsBetter = 0.7;  // maximum ratio of the ATE with to the ATE without time offset

class RecordingTracker {
 public:
  RecordingTracker(const SequenceOptions& options, const SequenceInfo& info)
      : info_(info), slam_(info.sensor(), SlamOptions(), Rigid3d()) {
    if (!info.has_clock || info.mirrored) return;
    std::optional<ImuRecording> imu = ReadImu(options, info.format);
    if (imu) slam_.UseImu(*std::move(imu));
  }

  void Process(const RgbdFrame& frame) {
    ++tracked_.frames;
    tracked_.lost += !slam_.Process(frame).HasPose();
    has_color_ |= !frame.color.empty();
  }

  TrackedRecording Finish() {
    slam_.Finish();
    if (ImuReport imu = slam_.imu_report(); !imu.read_from.empty()) tracked_.imu = std::move(imu);
    const Backend& backend = *slam_.backend();
    if (backend.is_recalibrated()) {
      tracked_.calibration = *backend.calibration();
      tracked_.calibration_warning = CalibrationWarning(info_.sensor(), *tracked_.calibration);
    }
    // With a wrong calibration, latencies are unreliable.
    if (!tracked_.calibration_warning.empty()) return tracked_;
    if (has_color_ && !backend.calibrations().empty())
      tracked_.color_latency_s = backend.color_latency_s();
    tracked_.late_s = LatenessByTruth(backend.poses().trajectory());
    return tracked_;
  }

 private:
  // Correction of the configured depth latency, s. std::nullopt if there is no ground truth, or if
  // its clock is not the clock of the frames. 0 if the best time offset hardly reduces the ATE.
  std::optional<double> LatenessByTruth(const Trajectory& estimate) const {
    if (!info_.has_clock) return std::nullopt;
    const auto as_it_is = EvaluateTimeOffset(info_.ground_truth, estimate, 0, {});
    const auto best = EstimateTimeOffset(info_.ground_truth, estimate, {});
    if (!as_it_is || !best) return std::nullopt;
    const bool fits_better =
        best->ate.translation_m.rmse < kFitsBetter * as_it_is->ate.translation_m.rmse;
    return fits_better ? -best->offset_s : 0;
  }

  const SequenceInfo& info_;
  Slam slam_;
  TrackedRecording tracked_;
  bool has_color_ = false;
};

class RecordingChecker {
 public:
  explicit RecordingChecker(const RecordingCheckOptions& options)
      : sequence_(OpenRawSequence(options.sequence)),
        figures_(sequence_.info.camera.depth_units_per_metre),
        sample_every_(std::max(1, sequence_.info.frame_count / kSamples)) {
    if (options.track)
      tracker_ = std::make_unique<RecordingTracker>(options.sequence, sequence_.info);
  }

  // Reads and evaluates the next frame. Returns false at the end of the recording.
  bool Next() {
    const std::optional<RawFrame> raw = sequence_.frames->Next();
    if (!raw) return false;
    try {
      if (!raw->head.error.empty()) throw InputError(raw->head.error);
      Look(*raw, sequence_.frames->Read());
    } catch (const InputError& error) {
      unreadable_.Tell(Concat("frame ", raw->head.index, ": ", error.what()));
      figures_.AddUnreadable(raw->head.index, raw->stamps, error.what());
    }
    return true;
  }

  RecordingReport Report() {
    std::optional<double> depth_step;
    if (!sequence_.info.camera.disparity.IsGiven()) depth_step = figures_.InverseDepthStep();
    RecordingEvidence evidence = {sequence_.info,
                                  figures_.frames(),
                                  sampled_depths_,
                                  doubted_scales_,
                                  depth_step,
                                  MeasureNoise(first_depths_m_, sequence_.info.pinhole),
                                  sequence_.registration,
                                  {}};
    if (tracker_) evidence.tracked = tracker_->Finish();
    RecordingReport report = {
        sequence_.info, static_cast<int>(figures_.frames().size()), {}, false};
    for (const auto& look : {ChecksOfFrames, ChecksOfStamps, ChecksOfSensor}) {
      for (RecordingCheck& check : look(evidence)) report.checks.push_back(std::move(check));
    }
    return report;
  }

 private:
  void Look(const RawFrame& raw, const FrameImages& images) {
    RgbdFrame frame = sequence_.MakeFrame(raw, images);
    figures_.Add(raw.head.index, raw.stamps, images, frame.depth_m);
    if (first_depths_m_.size() < MeasuredNoise::kFrames) first_depths_m_.push_back(frame.depth_m);
    if (count_++ % sample_every_ == 0) CheckScale(images);
    if (tracker_) tracker_->Process(frame);
  }

  void CheckScale(const FrameImages& images) {
    const RgbdCamera& camera = sequence_.info.camera;
    if (camera.disparity.IsGiven()) return;
    ++sampled_depths_;
    auto doubt = DepthScaleWarning(images.depth, camera.depth_units_per_metre, images.depth_name,
                                   sequence_.scale_is_given);
    if (doubt) doubted_scales_.push_back(std::move(*doubt));
  }

  RawSequence sequence_;
  RecordingStatistics figures_;
  RepeatedWarning unreadable_{"unreadable frames"};
  const int sample_every_;
  int count_ = 0, sampled_depths_ = 0;
  std::vector<std::string> doubted_scales_;
  std::vector<Image<float>> first_depths_m_;
  std::unique_ptr<RecordingTracker> tracker_;  // null: no tracking
};

}  // namespace

bool RecordingReport::IsSound() const {
  return std::all_of(checks.begin(), checks.end(), [](const auto& c) { return c.IsSound(); });
}

RecordingReport CheckRecording(const RecordingCheckOptions& options,
                               const std::atomic<bool>& interrupted,
                               const std::function<void(int frames)>& progress) {
  Validate(options);
  const ThreadLimit limit(options.threads);
  RecordingChecker look(options);
  for (int frames = 1; !interrupted && look.Next(); ++frames) progress(frames);
  RecordingReport report = look.Report();
  report.interrupted = interrupted;
  return report;
}

}  // namespace surfit
