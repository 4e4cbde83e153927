#pragma once

#include <optional>
#include <string>
#include <vector>

#include "surfit/frame/rgbd_frame.h"
#include "surfit/geometry/sensor.h"
#include "surfit/geometry/trajectory.h"

namespace surfit {

// Properties of a sequence, available before the first frame is read.
struct SequenceInfo {
  std::string format;  // a format of SequenceOptions, never "auto"
  // Camera of the files; fy can be negative. For the latency see `has_clock`.
  RgbdCamera camera;
  std::string camera_from;         // source of the camera, for messages: file, preset or option
  bool camera_is_guessed = false;  // no source: a common camera is assumed
  // Ratio of depth values that are removed from the first images because of low confidence.
  // std::nullopt without confidence images, see SequenceOptions::confidence.
  std::optional<double> low_confidence_ratio;
  // Largest value of the confidence images: 2 (phones) or 255. 0: none.
  int confidence_range = 0;
  bool IsPhone() const { return confidence_range == 2; }
  // Assumed properties in two log lines, already logged: format, number of frames, image sizes,
  // colour registration and confidence; depth camera, depth scale and `camera_from`.
  std::string assumed;
  PinholeCamera pinhole;  // camera of the frames: undistorted, downsampled, fy > 0
  // Sensor model of the frames.
  DepthSensor sensor() const { return {pinhole, camera.noise, camera.readout_s, camera.prior}; }
  int frame_count = 0;  // number of frames of Next(); -1: unknown, as for OpenLive()
  // True if timestamps are clock times. False for frame numbers and for sens (its poses have the
  // times of frames). If false, RgbdCamera::latency_s is 0.
  bool has_clock = false;
  // Ratio of depth and colour images without a partner of similar time. 0 if the recording stores
  // pairs.
  double unpaired_ratio = 0;
  // True if the camera y axis of the files points up (fy < 0). Frames and ground truth are then
  // mirrored by S = diag(1, -1, 1): a pose becomes S pose S. Mirrored() converts poses back to the
  // convention of the files.
  bool mirrored = false;
  // Ground-truth poses world_from_camera, mirrored if `mirrored` is true; may be empty. Times are
  // those of the frames if the files assign poses to frames, otherwise those of the pose file.
  Trajectory ground_truth;
  // Warnings about camera, depth scale, colour registration and confidence, already logged.
  std::vector<std::string> warnings;
};

// Result of reading one frame.
struct ReadResult {
  // Number of the frame in the recording, from 0, before SequenceOptions::first and ::stride.
  // Dropped frames of a camera have numbers, too.
  int index = 0;
  double stamp_s = 0;              // RgbdFrame::stamp_s, also if unreadable
  std::optional<RgbdFrame> frame;  // std::nullopt: unreadable files
  std::string error;               // reason with the file name, if unreadable
  double read_ms = 0;              // time to read and prepare the frame
  // Members for OfferFrames() and cameras; 0 for other sources.
  double waited_ms = 0;        // time that Next() waited for the frame
  double queued_ms = 0;        // time from the arrival of the frame to its return by Next()
  int dropped_before = 0;      // number of frames dropped since the last result
  double paused_before_s = 0;  // time without camera connection before this frame
};

// Sequence of RGB-D frames, from OpenSequence(), OpenLive() or the functions beside them in
// sequence.h. Next() must be called by one thread at a time.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  // Valid as long as the source. Does not change after construction. Thread-safe, also during
  // Next().
  virtual const SequenceInfo& info() const = 0;
  // Returns the next frame, or std::nullopt at the end, also in later calls. Frames are in the
  // order of the recording: stamp_s decreases if its clock is set back. The frame owns its images.
  // An unreadable frame is a result without `frame`, and the sequence continues. Live sources wait
  // for the next frame. Throws InputError if a camera or a watched folder fails. Do not call Next()
  // again after an exception.
  virtual std::optional<ReadResult> Next() = 0;
};

}  // namespace surfit
