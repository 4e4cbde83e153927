#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "surfit/io/sequence.h"

namespace surfit {

class OptionVisitor;

struct RecordingCheckOptions {
  SequenceOptions sequence;
  bool track = true;  // run SLAM to check calibration and latency; slower
  int threads = 2;

  void Visit(OptionVisitor& visitor);
};

struct RecordingCheck {
  std::string name;             // for example "median_depth"
  std::optional<double> value;  // std::nullopt: not measurable
  std::string unit;             // "m", "px", "%", "ms", "1/m", or empty
  std::string constraint;       // accepted values, for example "0.4 to 5"
  // Error message and remedy. Both are empty if the check passes.
  std::string fault, advice;

  bool IsSound() const { return fault.empty(); }
};

struct RecordingReport {
  SequenceInfo info;
  int frames = 0;  // includes unreadable frames
  std::vector<RecordingCheck> checks;
  bool interrupted = false;  // true: only the frames before the interruption are checked

  bool IsSound() const;  // true if all checks pass
};

// Checks all frames of a recording:
// - depth scale, depth range, ratio of valid depth, image size
// - registration and latency of colour, exposure, blur
// - missing and repeated frames, timestamps
// - with `track`, the calibration, and signs, units and axes of an inertial sensor
//
// `progress` must not be empty. It receives the number of frames read so far. If `interrupted`
// becomes true, stops before the next frame. Throws InputError for invalid options, or if the
// recording cannot be opened.
RecordingReport CheckRecording(const RecordingCheckOptions& options,
                               const std::atomic<bool>& interrupted,
                               const std::function<void(int frames)>& progress);

}  // namespace surfit
