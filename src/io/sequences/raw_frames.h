#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <vector>

#include "io/sequences/recording.h"
#include "surfit/frame/frame_source.h"
#include "surfit/frame/prepare_frame.h"
#include "surfit/geometry/inverse_depth_field.h"
#include "surfit/io/sequence.h"

namespace surfit {

// A frame before its images are read.
struct RawFrame {
  ReadResult head;     // without the frame, and the stamp; an error if there are no images
  FrameStamps stamps;  // as recorded
};

// The frames of a sequence as they were recorded, one after the other. Not thread-safe.
class RawFrames {
 public:
  virtual ~RawFrames() = default;
  // Images of some of the first frames, to see what they are like; before Next(). Throws InputError
  // if no frame can be read.
  virtual std::vector<FrameImages> FirstImages() = 0;
  // The next frame in order, or nothing at the end.
  virtual std::optional<RawFrame> Next() = 0;
  // Its images; once, if it has no error. Throws InputError naming what cannot be read.
  virtual FrameImages Read() = 0;
};

// A sequence that is open.
struct RawSequence {
  SequenceInfo info;
  std::unique_ptr<RawFrames> frames;
  FramePreparer preparer;
  InverseDepthField field;  // ReadDepthField()
};

// What OpenSequence() and OpenLive() read, before it is prepared. Throw InputError as they do.
RawSequence OpenRawSequence(const SequenceOptions& options);
RawSequence OpenRawLive(const SequenceOptions& options, int capacity,
                        const std::atomic<bool>& stop);

// What WatchFolder() reads, before it is prepared. The options are valid.
RawSequence OpenWatchedFolder(const SequenceOptions& options, const std::atomic<bool>& stop);

// OpenNI2's camera that options.path names, and a recording of OpenNI2, whose camera is told by the
// field of view. Throw InputError naming the device or file, also where this was built without
// OpenNI2.
RawSequence OpenOpenNiCamera(const SequenceOptions& options, int capacity,
                             const std::atomic<bool>& stop);
OpenedRecording OpenOni(const SequenceOptions& options);

// Completes what is known of a sequence by its first images.
RawSequence Complete(SequenceInfo info, std::unique_ptr<RawFrames> frames,
                     const SequenceOptions& options);

// The frames, prepared.
std::unique_ptr<FrameSource> Prepared(RawSequence sequence);

}  // namespace surfit
