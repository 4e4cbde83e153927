#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>

#include "surfit/io/sequence.h"

namespace surfit {

class OptionVisitor;

struct RecordOptions {
  SequenceOptions sequence;  // sequence to record; `prepare` must have its default values
  std::string output;        // folder, must not contain a recording
  int max_frames = 0;        // maximum number of frames; 0: no limit
  double max_seconds = 0;    // maximum duration by the timestamps, s; 0: no limit
  int queue_capacity = 60;   // live camera: maximum number of frames that wait for writing

  void Visit(OptionVisitor& visitor);
};

// Statistics of a recording.
struct RecordSummary {
  int frames_written = 0;
  int frames_skipped = 0;                // unreadable frames
  int frames_dropped = 0;                // live camera: frames that were not written in time
  int pauses = 0;                        // live camera: number of disconnections
  double seconds = 0;                    // duration by the timestamps, s
  std::int64_t bytes = 0;                // total size of the images
  std::int64_t depths_out_of_range = 0;  // depth values above 16 bits, written as missing
  bool depth_is_rounded = false;         // depth in m was converted to counts of 1 / 5000 m
  bool interrupted = false;
};

// Records a sequence or a live camera as a folder in the TUM format: rgb/, depth/, rgb.txt,
// depth.txt, associations.txt, camera.yaml, and groundtruth.txt if the source has poses. Images and
// timestamps are bitwise identical to the source, except depth in m, which is converted to counts
// of 1 / 5000 m. Images are written before their lines in the lists, so that an interrupted
// recording is valid. Ends when `stop` becomes true. Calls `progress` after each frame. Throws
// InputError with the option, file or folder at fault.
RecordSummary RecordSequence(const RecordOptions& options, const std::atomic<bool>& stop,
                             const std::function<void(const RecordSummary&)>& progress);

}  // namespace surfit
