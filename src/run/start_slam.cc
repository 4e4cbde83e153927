#include "run/start_slam.h"

#include <glog/logging.h>

#include <array>
#include <cstdio>
#include <optional>
#include <utility>

#include "io/sequences/raw_frames.h"
#include "run/posed_views.h"
#include "run/results/tracking_dump.h"
#include "surfit/core/error.h"
#include "surfit/io/sequence.h"

namespace surfit {
namespace {

std::string DumpFolder(const std::string& folder, int frame) {
  std::array<char, 30> name;
  std::snprintf(name.data(), name.size(), "/frame-%06d", frame);
  return folder + name.data();
}

// Mirrored frames have a left-handed camera frame, so no rotation maps the sensor to it.
void UseImu(const SlamRunOptions& options, const SequenceInfo& info, Slam* slam) {
  std::optional<ImuRecording> imu = ReadImu(options.sequence, info.format);
  if (!imu) return;
  if (!info.has_clock || info.mirrored) {
    LOG(WARNING) << imu->read_from << " is not used: "
                 << (info.mirrored ? "frames with fy < 0 have a left-handed camera frame"
                                   : "frame numbers are no times");
    return;
  }
  LOG(INFO) << "inertial sensor: " << imu->samples.size() << " samples from " << imu->read_from;
  slam->UseImu(*std::move(imu));
}

Trajectory ReadPriorPoses(const std::string& path, const SequenceInfo& info) {
  Trajectory prior = ReadEstimate(path, info);
  ThrowIf(prior.size() < 2, path, " has ", prior.size(), " poses, must have at least 2");
  for (std::size_t i = 1; i < prior.size(); ++i) {
    ThrowIf(prior[i].stamp_s == prior[i - 1].stamp_s, path, " has two poses with the timestamp ",
            std::to_string(prior[i].stamp_s), ", timestamps must differ");
  }
  return prior;
}

}  // namespace

// Live sequences are not read ahead, because a wait for the camera would block a worker thread.
std::unique_ptr<FrameSource> OpenSource(const SlamRunOptions& options,
                                        const std::atomic<bool>& interrupted) {
  if (IsLive(options.sequence)) {
    return OpenLive(options.sequence, options.queue_capacity, interrupted);
  }
  auto source = OpenSequence(options.sequence);
  if (options.offered_fps == 0) return ReadAhead(std::move(source), options.queue_capacity);
  return OfferFrames(std::move(source), options.offered_fps, options.queue_capacity);
}

SequenceInfo WithGroundTruth(SequenceInfo info, const SlamRunOptions& options) {
  if (options.groundtruth == "device") {
    info.ground_truth = InConvention(ReadDevicePoses(options.sequence), info);
    info.warnings.emplace_back(
        "groundtruth is 'device': errors are differences from the poses of the phone, which have "
        "errors of their own");
    LOG(WARNING) << info.warnings.back();
  } else if (!options.groundtruth.empty()) {
    info.ground_truth = ReadEstimate(options.groundtruth, info);
  }
  ThrowIf(options.fit_mount && info.ground_truth.empty(), "fit_mount is true, but ",
          options.sequence.path, " has no ground truth");
  ThrowIf(options.poses == "groundtruth" && info.ground_truth.empty(),
          "poses is 'groundtruth', but ", options.sequence.path, " has no ground truth");
  return info;
}

void WeighColor(const SequenceInfo& info, const NoiseReport& noise, bool has_color,
                SlamOptions* options) {
  constexpr double kWeight = 1;
  constexpr double kExactDepth = 0.0003;  // noise, 1/m: 1.2 mm at 2 m
  const bool is_possible = has_color && options->icp.solver != "svd" &&
                           options->weakly_constrained_photometric_weight > 0;
  double* const weight = &options->icp.error_model.photometric_weight;
  if (!info.IsPhone() || !is_possible || *weight > 0) return;
  if (noise.measured && *noise.measured < kExactDepth) return;
  *weight = kWeight;
  LOG(INFO) << "depth of a phone is interpolated, so colour takes part in tracking with the "
               "photometric weight "
            << kWeight;
}

void KeepCalibrationOfPhones(const SequenceInfo& info, SlamOptions* options) {
  if (!info.IsPhone() || !(info.camera.prior == CalibrationPrior())) return;
  if (!std::exchange(options->calibration.enabled, false)) return;
  LOG(INFO)
      << "a phone calibrates itself, so the run keeps its calibration; a prior in camera.yaml "
         "makes the run calibrate";
}

std::unique_ptr<Slam> StartSlam(const SlamRunOptions& options, const SequenceInfo& info,
                                RunSession* session, double first_stamp_s) {
  std::unique_ptr<Slam> slam;
  if (session && session->has_state()) {
    slam = session->MakeSlam(info, options.slam);
  } else {
    slam = std::make_unique<Slam>(info.sensor(), options.slam,
                                  InitialPose(options.initial_pose, info, first_stamp_s));
  }
  if (session) session->Begin(info, slam.get());
  UseImu(options, info, slam.get());
  if (!options.prior_poses.empty()) {
    slam->UsePriorPoses(ReadPriorPoses(options.prior_poses, info));
  }
  if (!options.dump_failures.empty()) {
    slam->OnLostFrame([&options](const LostFrame& lost) {
      WriteTrackingDump(lost, options.slam, DumpFolder(options.dump_failures, lost.index));
    });
  }
  return slam;
}

void WarnOfPriorPoses(const std::string& path, const PriorPoseSummary& prior) {
  if (prior.frames_without > 0) {
    LOG(WARNING) << path << ": " << prior.frames_without
                 << " frames have no prior pose at their time";
  }
  if (prior.rejected.empty()) return;
  const auto& [from_s, to_s] = prior.rejected.front();
  LOG(WARNING) << path << ": " << prior.frames_rejected << " of " << prior.frames_compared
               << " frames in " << prior.rejected.size()
               << " stretches contradict the registered motion and are not used, first from "
               << std::to_string(from_s) << " s to " << std::to_string(to_s) << " s";
}

}  // namespace surfit
