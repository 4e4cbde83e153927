#pragma once

#include <optional>
#include <string>
#include <vector>

#include "surfit/frame/rgbd_frame.h"
#include "surfit/geometry/sensor.h"
#include "surfit/geometry/trajectory.h"

namespace surfit {

// Properties of a sequence. Available before the first frame is read.
struct SequenceInfo {
  std::string format;  // a format name of SequenceOptions, never "auto"
  // Camera of the files; fy can be negative. latency_s is 0 if `has_clock` is false.
  RgbdCamera camera;
  std::string camera_from;         // origin of the camera: file, preset or option
  bool camera_is_guessed = false;  // no origin found: a common camera is assumed
  // Ratio of depth that is removed from the first images because of low confidence. std::nullopt:
  // these images have no confidence, see SequenceOptions::confidence.
  std::optional<double> low_confidence_ratio;
  // Assumed properties in two log lines, already logged. Line 1: format, number of frames, image
  // sizes, colour registration, confidence. Line 2: depth camera, depth scale and `camera_from`.
  std::string assumed;
  PinholeCamera pinhole;  // of the frames of Next(): undistorted, downsampled, fy > 0
  // Sensor model of the frames of Next().
  DepthSensor sensor() const { return {pinhole, camera.noise, camera.readout_s, camera.prior}; }
  int frame_count =
      0;  // number of frames that Next() tries to read; -1: unknown, as for OpenLive()
  // True if timestamps are times of a clock. False if they are frame numbers, or if the files
  // assign poses to frames. Latencies apply to clocks only.
  bool has_clock = false;
  // Ratio of depth and colour images without a partner of about the same time. 0 if the recording
  // stores pairs.
  double unpaired_ratio = 0;
  // True if the image y axis of the files points up (fy < 0). Frames and ground truth are then
  // mirrored by S = diag(1, -1, 1) when they are read: poses become S pose S. Apply Mirrored()
  // again to write poses in the convention of the files.
  bool mirrored = false;
  // Ground-truth poses world_from_camera, mirrored if `mirrored` is true. Empty: none. Poses of
  // single frames have the timestamps of these frames. Other poses, for example of motion capture,
  // have the timestamps of the files.
  Trajectory ground_truth;
  // Warnings about camera, depth scale, colour registration and missing confidence images, already
  // logged.
  std::vector<std::string> warnings;
};

// Result of an attempt to read a frame.
struct ReadResult {
  int index = 0;                   // position in the sequence, before --stride
  double stamp_s = 0;              // timestamp, also of an unreadable frame
  std::optional<RgbdFrame> frame;  // std::nullopt: unreadable files
  std::string error;               // reason with the file name, if unreadable
  double read_ms = 0;              // time for reading and preparation
  // Set by OfferFrames() and by cameras only:
  double waited_ms = 0;    // time that Next() waited for the frame
  double queued_ms = 0;    // time that the frame waited for Next()
  int dropped_before = 0;  // frames dropped since the last result
  // Time without a connection to the camera before this frame.
  double paused_before_s = 0;
};

// Sequence of RGB-D frames. Not thread-safe.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  virtual const SequenceInfo& info() const = 0;
  // Returns the next frame, or std::nullopt at the end.
  virtual std::optional<ReadResult> Next() = 0;
};

}  // namespace surfit
