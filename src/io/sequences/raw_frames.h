#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <vector>

#include "io/checks/recording_warnings.h"
#include "io/sequences/recording.h"
#include "surfit/frame/frame_source.h"
#include "surfit/frame/rectify_frame.h"
#include "surfit/geometry/inverse_depth_field.h"
#include "surfit/geometry/trajectory.h"
#include "surfit/io/sequence.h"

namespace surfit {

struct RawFrame {
  ReadResult head;     // index, times and counts; an error if the frame has no images
  FrameStamps stamps;  // as recorded
};

// Frames of a sequence as recorded, in order. Not thread-safe. Order: FirstImages(), then Next(),
// and at most one Read() after each Next(). Next() also returns the frames of FirstImages(), if the
// options select them.
class RawFrames {
 public:
  virtual ~RawFrames() = default;
  // Images of up to eight frames, beginning with the first readable frame. Call it before Next().
  // Throws InputError if no frame can be read.
  virtual std::vector<FrameImages> FirstImages() = 0;
  // Next frame, or std::nullopt at the end. Live frames are waited for. Throws InputError if a
  // camera or a watched folder fails.
  virtual std::optional<RawFrame> Next() = 0;
  // Images of the frame that Next() returned. Call it at most once per frame, and only for frames
  // without an error. Throws InputError naming the file that cannot be read.
  virtual FrameImages Read() = 0;
};

// Open sequence: its frames and the conversion of their images to RgbdFrames.
struct RawSequence {
  SequenceInfo info;
  std::unique_ptr<RawFrames> frames;
  FrameRectifier rectifier;
  InverseDepthField field;      // ReadDepthField()
  bool scale_is_given = false;  // ResolveCamera()
  // Alignment of registered colour in the first images. std::nullopt: no colour or too few edges.
  std::optional<RegistrationFit> registration = {};

  // Rectifies the images and applies the depth correction. Throws InputError like RectifyFrame().
  // `images`: result of RawFrames::Read() for this frame. Thread-safe.
  RgbdFrame MakeFrame(const RawFrame& raw, FrameImages images) const;
};

// Capture times: timestamps minus latency_s, and for colour also minus color_latency_s. A positive
// latency means that an image is captured before its timestamp.
FrameStamps CaptureTimes(const FrameStamps& stamps, const RgbdCamera& camera);

// Throws InputError naming the image and both sizes if a size differs from the camera's.
void RequireSizeOf(const RgbdCamera& camera, const FrameImages& images);

// Checks the image sizes and rectifies the images. `stamps` are timestamps as recorded. Throws
// InputError like RequireSizeOf(). `rectifier` must belong to the camera. Timestamps of the result
// are capture times.
RgbdFrame RectifyFrame(const RgbdCamera& camera, const FrameRectifier& rectifier,
                       FrameImages images, int index, const FrameStamps& stamps);

// Open the frames of OpenSequence() and of OpenLive(), without conversion. Throw InputError like
// these functions. Live frames end when `stop` becomes true. `stop` must outlive the frames.
// `capacity`: maximum number of frames of a camera that wait. Above it, the oldest is dropped.
RawSequence OpenRawSequence(const SequenceOptions& options);
RawSequence OpenRawLive(const SequenceOptions& options, int capacity,
                        const std::atomic<bool>& stop);

// Reads the poses that the recording device has estimated: stray_scanner, arkit_scenes, polycam,
// record3d, nerfstudio. Camera axes are x right, y down, z forward. The poses are no ground truth,
// so OpenSequence() does not return them. Logs the number of invalid poses, which are left out.
// Throws InputError that names the folder for other formats, and without a valid pose.
Trajectory ReadDevicePoses(const SequenceOptions& options);

// Implements WatchFolder(). Requires valid options.
RawSequence OpenWatchedFolder(const SequenceOptions& options, const std::atomic<bool>& stop);

// Opens the OpenNI2 camera `options.path`, with a queue of `capacity` frames, at least 1. Throws
// InputError naming the device, also in a build without OpenNI2.
RawSequence OpenOpenNiCamera(const SequenceOptions& options, int capacity,
                             const std::atomic<bool>& stop);

// Completes `info` with CompleteInfo() and the first images of `frames`, and removes a
// DepthEncoding from all frames. Throws InputError if no frame can be read, if the image size is
// wrong, or for a bad depth field. FirstImages() of `frames` must not have been called.
RawSequence MakeRawSequence(SequenceInfo info, std::unique_ptr<RawFrames> frames,
                            const SequenceOptions& options, bool scale_is_given);

// Source of rectified frames, with capture times as timestamps. Read errors of single frames are in
// ReadResult::error.
std::unique_ptr<FrameSource> MakeFrameSource(RawSequence sequence);

}  // namespace surfit
