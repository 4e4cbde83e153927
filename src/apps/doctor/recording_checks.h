#pragma once

#include <iomanip>
#include <optional>
#include <string>
#include <vector>

#include "apps/doctor/check_recording.h"
#include "apps/doctor/recording_statistics.h"
#include "io/sequences/recording_warnings.h"
#include "surfit/core/error.h"
#include "surfit/geometry/inverse_depth_field.h"

namespace surfit {

struct TrackedRecording {
  int frames = 0, lost = 0;
  std::string calibration_warning;              // CalibrationWarning(); may be empty
  std::optional<DepthCalibration> calibration;  // std::nullopt: no new estimate
  // Estimated latency minus configured latency; std::nullopt: unknown.
  std::optional<double> color_latency_s;
  // Depth latency by ground truth minus configured latency; std::nullopt: unknown.
  std::optional<double> late_s;
};

// Does not own the referenced objects.
struct RecordingEvidence {
  const SequenceInfo& info;
  const std::vector<FrameStatistics>& frames;
  int sampled_depths = 0;                       // number of frames with a check of the depth scale
  std::vector<std::string> doubted_scales;      // DepthScaleWarning() of these frames
  std::optional<double> inverse_depth_step;     // RecordingStatistics::InverseDepthStep()
  std::optional<RegistrationFit> registration;  // std::nullopt: not observable
  std::optional<TrackedRecording> tracked;      // std::nullopt: tracking is off
};

std::vector<RecordingCheck> ChecksOfFrames(const RecordingEvidence& evidence);
std::vector<RecordingCheck> ChecksOfStamps(const RecordingEvidence& evidence);
std::vector<RecordingCheck> ChecksOfSensor(const RecordingEvidence& evidence);

inline std::string Rounded(double value) { return Concat(std::setprecision(3), value); }

}  // namespace surfit
