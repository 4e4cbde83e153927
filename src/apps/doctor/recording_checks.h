#pragma once

#include <iomanip>
#include <optional>
#include <string>
#include <vector>

#include "apps/doctor/check_recording.h"
#include "apps/doctor/recording_figures.h"
#include "io/sequences/registration_doubt.h"
#include "surfit/core/error.h"
#include "surfit/geometry/inverse_depth_field.h"

namespace surfit {

// What tracking has found of a recording.
struct TrackedRecording {
  int frames = 0, lost = 0;
  std::string calibration_doubt;                // DoubtOfGiven(), empty without one
  std::optional<DepthCalibration> calibration;  // nothing where it is as given
  std::optional<double> color_latency_s;        // beyond the given one; nothing where not seen
  std::optional<double> late_s;  // likewise of the stamps, by ground truth of a clock
};

// All that is known of a recording when it is judged.
struct RecordingEvidence {
  const SequenceInfo& info;
  const std::vector<FrameFigures>& frames;
  int sampled_depths = 0;                       // that were looked at for their scale
  std::vector<std::string> doubted_scales;      // DepthScaleWarning() of those that are doubtful
  std::optional<double> inverse_depth_step;     // RecordingFigures
  std::optional<RegistrationFit> registration;  // nothing where nothing tells
  std::optional<TrackedRecording> tracked;      // nothing where it was not
};

// Of single frames and of their stamps.
std::vector<RecordingCheck> ChecksOfFrames(const RecordingEvidence& evidence);
std::vector<RecordingCheck> ChecksOfStamps(const RecordingEvidence& evidence);
// Of depth, of colour's place and time, and of what tracking found.
std::vector<RecordingCheck> ChecksOfSensor(const RecordingEvidence& evidence);

// A value for a sentence, with three digits.
inline std::string Rounded(double value) { return Concat(std::setprecision(3), value); }

}  // namespace surfit
