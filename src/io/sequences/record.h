#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>

#include "surfit/io/sequence.h"

namespace surfit {

class OptionVisitor;

// How a sequence is recorded.
struct RecordOptions {
  SequenceOptions sequence;  // what to record; `prepare` must be the default
  std::string output;        // the folder, which must hold no recording
  int max_frames = 0;        // end after so many; 0: at the sequence's end
  double max_seconds = 0;    // end after so much time by the frames' stamps; 0: at the end
  int queue_capacity = 60;   // of a camera: frames that may wait to be written

  void Visit(OptionVisitor& visitor);
};

// What has become of a sequence's frames.
struct RecordSummary {
  int frames_written = 0;
  int frames_skipped = 0;          // could not be read
  int frames_dropped = 0;          // of a camera: not written in time
  int pauses = 0;                  // of a camera: it was unplugged, and came back
  double seconds = 0;              // from the first frame's stamp to the last one's
  std::int64_t bytes = 0;          // of images
  std::int64_t depths_beyond = 0;  // that 16 bits cannot hold: written as missing
  bool depth_is_rounded = false;   // it was in metres: written in units of 1 / 5000 m
  bool interrupted = false;
};

// Records a sequence, or what a camera sends, as a folder in TUM's format: rgb/, depth/ (PNG, of
// the source's own counts), rgb.txt, depth.txt, associations.txt, camera.yaml, and groundtruth.txt
// where the source has poses. Images and stamps are the source's to the last bit, so that what is
// made of the folder is what is made of the source; but depth in metres becomes counts, 5000 a
// metre. A frame is in the lists once its images are on the disk, so that whatever ends the program
// leaves a good recording. Ends when `stop` becomes true. `progress` is called after each frame.
// Throws InputError naming the option, file or folder at fault.
RecordSummary RecordSequence(const RecordOptions& options, const std::atomic<bool>& stop,
                             const std::function<void(const RecordSummary&)>& progress);

}  // namespace surfit
