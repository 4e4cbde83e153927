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

// A frame whose images are not read yet.
struct RawFrame {
  ReadResult head;     // index and decode_ms; an error if the frame has no images
  FrameStamps stamps;  // as recorded
};

// Sequence of frames as recorded. Not thread-safe.
class RawFrames {
 public:
  virtual ~RawFrames() = default;
  // Images of up to eight frames from the first readable one on. Call it before Next(). Throws
  // InputError if no frame can be read.
  virtual std::vector<FrameImages> FirstImages() = 0;
  // The next frame in order, or std::nullopt at the end.
  virtual std::optional<RawFrame> Next() = 0;
  // Images of the frame that Next() returned. Call it at most once per frame, and only for frames
  // without an error. Throws InputError naming the file that cannot be read.
  virtual FrameImages Read() = 0;
};

// An open sequence: its camera and ground truth, its frames, and what turns images into RgbdFrames.
struct RawSequence {
  SequenceInfo info;
  std::unique_ptr<RawFrames> frames;
  FramePreparer preparer;
  InverseDepthField field;  // ReadDepthField()

  // Rectifies the images and corrects depth by the field. Throws InputError as PrepareFrame().
  RgbdFrame MakeFrame(const RawFrame& raw, FrameImages images) const;
};

// Capture times of the images: t = stamp - latency_s, and for colour - color_latency_s in addition.
FrameStamps CaptureTimes(const FrameStamps& stamps, const RgbdCamera& camera);

// Throws InputError naming the image and both sizes if a size differs from the camera's.
void RequireSizeOf(const RgbdCamera& camera, const FrameImages& images);

// Checks the image sizes and rectifies the images. `stamps` are as recorded. Throws InputError as
// RequireSizeOf().
RgbdFrame PrepareFrame(const RgbdCamera& camera, const FramePreparer& preparer, FrameImages images,
                       int index, const FrameStamps& stamps);

// Opens the frames of OpenSequence() and of OpenLive(). Both throw InputError as these do.
RawSequence OpenRawSequence(const SequenceOptions& options);
RawSequence OpenRawLive(const SequenceOptions& options, int capacity,
                        const std::atomic<bool>& stop);

// Opens the frames of WatchFolder(). The options must be valid.
RawSequence OpenWatchedFolder(const SequenceOptions& options, const std::atomic<bool>& stop);

// Opens the OpenNI2 camera that options.path names.
// Throws InputError naming the device, also in a build without OpenNI2.
RawSequence OpenOpenNiCamera(const SequenceOptions& options, int capacity,
                             const std::atomic<bool>& stop);

// Completes `info` by the first images of `frames`.
RawSequence MakeRawSequence(SequenceInfo info, std::unique_ptr<RawFrames> frames,
                            const SequenceOptions& options);

// The frames of the sequence, read and rectified.
std::unique_ptr<FrameSource> MakeFrameSource(RawSequence sequence);

}  // namespace surfit
