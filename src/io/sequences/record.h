#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>

#include "surfit/io/sequence.h"

namespace surfit {

class OptionVisitor;

struct RecordOptions {
  SequenceOptions sequence;  // `downsample` and `max_depth_m` must have their default values
  std::string output;        // folder, created if missing; must not contain depth.txt
  int max_frames = 0;        // maximum number of frames; 0: no limit
  double max_seconds = 0;    // maximum duration by the timestamps, s; 0: no limit

  void Visit(OptionVisitor& visitor);
};

struct RecordSummary {
  int frames_written = 0;
  int frames_skipped = 0;                // unreadable frames
  int frames_dropped = 0;                // live camera: frames that were not written in time
  int pauses = 0;                        // live camera: number of disconnections
  double seconds = 0;                    // duration by the timestamps, s
  std::int64_t bytes = 0;                // total size of the image files
  std::int64_t depths_out_of_range = 0;  // depth in m: values above 13.1 m, written as missing
  bool depth_is_rounded = false;         // depth in m was converted to counts of 1 / 5000 m
  bool interrupted = false;              // `stop` was true at the end
  // Pixels with depth in frames with confidence, and the number of them with low confidence, which
  // are written as missing.
  std::int64_t depths = 0, low_confidence = 0;
};

// Records a sequence or a live camera as a folder in the TUM format: rgb/, depth/, rgb.txt,
// depth.txt, associations.txt and camera.yaml. Ground truth in the convention of the source is in
// groundtruth.txt, if there are poses. Without colour, there is no rgb.txt and no associations.txt.
//
// Pixel values and timestamps are identical to the source, with three exceptions. DepthEncoding is
// removed. Depth in m is converted to counts of 1 / 5000 m. Depth of low confidence is written as
// missing, because confidence images are not written (SequenceOptions::confidence). Images are
// stored as PNG. Images are written before their lines in the lists, so that an interrupted
// recording is valid.
//
// Ends at the end of the sequence, at a limit of the options, or when `stop` becomes true. Calls
// `progress`, which must not be empty, after each written frame. Throws InputError with the option,
// file or folder at fault, if no frame could be recorded, and if only some frames have colour.
// `stop` is checked before each frame.
RecordSummary RecordSequence(const RecordOptions& options, const std::atomic<bool>& stop,
                             const std::function<void(const RecordSummary&)>& progress);

}  // namespace surfit
