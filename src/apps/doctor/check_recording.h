#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "surfit/io/sequence.h"

namespace surfit {

class OptionVisitor;

// Which recording is looked at, and how.
struct RecordingCheckOptions {
  SequenceOptions sequence;
  bool track = true;  // by SLAM, which tells of calibration and latency; slower
  int threads = 2;    // that compute at the same time

  void Visit(OptionVisitor& visitor);
};

// One thing that was looked at.
struct RecordingCheck {
  std::string name;             // "median_depth"
  std::optional<double> value;  // what was measured; nothing where the recording does not tell
  std::string unit;             // of the value: "m", "px", "%", "ms", ...
  std::string constraint;       // what a sound recording has: "0.4 to 5 m"
  // Of a fault: a sentence with the value and the constraint, and one that says what to do. Empty
  // where nothing is wrong.
  std::string fault, advice;

  bool IsSound() const { return fault.empty(); }
};

// What is known of a recording once all of it was read.
struct RecordingReport {
  SequenceInfo info;
  int frames = 0;  // that were read
  std::vector<RecordingCheck> checks;
  bool interrupted = false;  // only the frames so far were looked at

  bool IsSound() const;
};

// Reads a recording from one end to the other, tracks its camera, and tells what is wrong with it:
// the depth's scale, colour's registration and latency, exposure, blur, frames that are missing or
// repeated, the calibration, the share and range of valid depth, the images' size. `progress` is
// called with the frames read so far. Throws InputError for bad options, or if no frame can be
// read.
RecordingReport CheckRecording(const RecordingCheckOptions& options,
                               const std::atomic<bool>& interrupted,
                               const std::function<void(int frames)>& progress);

}  // namespace surfit
