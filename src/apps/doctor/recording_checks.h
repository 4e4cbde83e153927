#pragma once

#include <iomanip>
#include <optional>
#include <string>
#include <vector>

#include "apps/doctor/check_recording.h"
#include "apps/doctor/recording_statistics.h"
#include "calibration/calibrator.h"
#include "io/sequences/raw_frames.h"
#include "surfit/core/error.h"
#include "surfit/geometry/inertial.h"
#include "surfit/geometry/inverse_depth_field.h"

namespace surfit {

// Results of SLAM on the recording. A positive latency correction means that the image was captured
// earlier than its timestamp minus the configured latency.
struct TrackedRecording {
  int frames = 0, lost = 0;
  std::string calibration_warning;              // CalibrationWarning(); may be empty
  std::optional<DepthCalibration> calibration;  // std::nullopt: no new estimate
  // Estimated latency of colour relative to depth, minus the configured latency. std::nullopt: no
  // colour, no estimate, or a wrong calibration.
  std::optional<double> color_latency_s;
  // Depth latency by ground truth minus configured latency. std::nullopt: no ground truth, no
  // common clock, or a wrong calibration. 0: a time offset hardly reduces the ATE.
  std::optional<double> late_s;
  std::optional<ImuReport> imu;  // std::nullopt: no inertial sensor
};

// Input of the checks. The referenced objects must outlive this object.
struct RecordingEvidence {
  const SequenceInfo& info;
  const std::vector<FrameStatistics>& frames;
  int sampled_depths = 0;                       // number of frames with a check of the depth scale
  std::vector<std::string> doubted_scales;      // DepthScaleWarning() of these frames
  std::optional<double> inverse_depth_step;     // RecordingStatistics::InverseDepthStep(), 1/m
  std::optional<MeasuredNoise> noise;           // MeasureNoise() of the first frames
  std::optional<RegistrationFit> registration;  // std::nullopt: not observable
  std::optional<TrackedRecording> tracked;      // std::nullopt: tracking is off
};

// Checks of images, of timestamps, and of sensor and calibration, in a fixed order. A check without
// data passes, and has no value or the value 0. ChecksOfSensor() adds the tracking checks if
// `tracked` is set. A recording without frames is valid input.
std::vector<RecordingCheck> ChecksOfFrames(const RecordingEvidence& evidence);
std::vector<RecordingCheck> ChecksOfStamps(const RecordingEvidence& evidence);
std::vector<RecordingCheck> ChecksOfSensor(const RecordingEvidence& evidence);

// Number with three significant digits.
inline std::string Rounded(double value) { return Concat(std::setprecision(3), value); }

}  // namespace surfit
