#pragma once

#include <optional>
#include <string>
#include <vector>

#include "surfit/frame/rgbd_frame.h"
#include "surfit/geometry/sensor.h"
#include "surfit/geometry/trajectory.h"

namespace surfit {

// What is known of a sequence before its first frame is read.
struct SequenceInfo {
  std::string format;  // one of those that SequenceOptions names, never auto
  // As the files have it, fy < 0 included. Its latency is what frames are earlier than their files'
  // stamps: 0 where these are none of a clock, but made of the frames' numbers.
  RgbdCamera camera;
  std::string camera_from;         // the file, preset or option that tells it
  bool camera_is_guessed = false;  // nothing tells it: it is a usual one
  // What is taken for granted, logged already, in two lines: format, frames, sizes and whether
  // colour is registered; the depth camera with its scale, and where it is from.
  std::string assumed;
  PinholeCamera pinhole;  // of the frames that Next() returns: undistorted, downsampled, fy > 0
  // What the depth of these frames is.
  DepthSensor sensor() const { return {pinhole, camera.noise, camera.readout_s, camera.prior}; }
  int frame_count =
      0;  // how many frames Next() will attempt; -1: as many as will come (OpenLive())
  // Stamps are of a clock, to which the sensor has a latency; else they are the frames' numbers, or
  // poses are given frame by frame.
  bool has_clock = false;
  // Of all the recording's images of depth and colour, those that no frame has, for want of one of
  // the other that was taken at about the same time; 0 where the recording pairs them itself.
  double unpaired_share = 0;
  // The files' image y axis points up (fy < 0). Frames and ground truth are then mirrored by
  // S = diag(1, -1, 1) when read: camera and world, poses become S pose S. Whoever writes poses
  // back in the source's convention conjugates them again.
  bool mirrored = false;
  // World-from-camera poses in our (mirrored, if so) convention, for evaluation; empty if there
  // are none. Poses that belong to the frames have their stamps; others (motion capture) the
  // files', which need not equal the frames'.
  Trajectory ground_truth;
  // What the user should know, logged already: doubtful camera, depth scale, registration.
  std::vector<std::string> warnings;
};

// One attempt to read a frame.
struct ReadResult {
  int index = 0;                   // position in the sequence, before --stride
  double stamp_s = 0;              // the frame's, also of one that could not be read
  std::optional<RgbdFrame> frame;  // empty if the files could not be read
  std::string error;               // then why, naming the file
  double decode_ms = 0;            // time spent reading and preparing it
  // Of frames that are offered at a rate (OfferFrames()) or come from a camera:
  double waited_ms = 0;    // time that the reader was early
  double queued_ms = 0;    // or the frame waited to be taken
  int dropped_before = 0;  // frames that were not taken in time
  // Of a camera: how long it had been unplugged before this frame.
  double paused_before_s = 0;
};

// A sequence of RGB-D frames. Not thread-safe.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  virtual const SequenceInfo& info() const = 0;
  // The next frame in order, or nothing at the end.
  virtual std::optional<ReadResult> Next() = 0;
};

}  // namespace surfit
