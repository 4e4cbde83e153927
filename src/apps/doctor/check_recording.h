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
  std::string name;             // "median_depth"
  std::optional<double> value;  // measured value; std::nullopt: not observable
  std::string unit;             // unit of the value: "m", "px", "%", "ms", ...
  std::string constraint;       // accepted values: "0.4 to 5"
  // Fault: measured value and constraint. Advice: remedy. Both are empty if the check passes.
  std::string fault, advice;

  bool IsSound() const { return fault.empty(); }
};

// Results of all checks of a recording.
struct RecordingReport {
  SequenceInfo info;
  int frames = 0;  // includes unreadable frames
  std::vector<RecordingCheck> checks;
  bool interrupted = false;  // true: only the frames before the interruption were checked

  bool IsSound() const;
};

// Checks all frames of a recording:
// - depth scale, depth range, ratio of valid depth, image size
// - registration and latency of colour, exposure, blur
// - missing and repeated frames, timestamps
// - with `track`, the calibration
//
// Calls `progress` with the number of frames read so far. Stops before the next frame if
// `interrupted` is true. Throws InputError for invalid options, or if the recording cannot be
// opened.
RecordingReport CheckRecording(const RecordingCheckOptions& options,
                               const std::atomic<bool>& interrupted,
                               const std::function<void(int frames)>& progress);

}  // namespace surfit
