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
  std::string format;     // tum, icl_nuim, seven_scenes, redwood, replica, klg, sens, watch
  RgbdCamera camera;      // as the files have it, fy < 0 included
  PinholeCamera pinhole;  // of the frames that Next() returns: undistorted, downsampled, fy > 0
  // What the depth of these frames is.
  DepthSensor sensor() const { return {pinhole, camera.noise}; }
  int frame_count = 0;  // how many frames Next() will attempt; -1: as many as will come (watch)
  // The files' image y axis points up (fy < 0). Frames and ground truth are then mirrored by
  // S = diag(1, -1, 1) when read: camera and world, poses become S pose S. Whoever writes poses
  // back in the source's convention conjugates them again.
  bool mirrored = false;
  // World-from-camera poses in our (mirrored, if so) convention, for evaluation; empty if there
  // are none. Its stamps are the files'; they need not equal the frames'.
  Trajectory ground_truth;
  // What the user should know, logged already: doubtful camera, depth scale.
  std::vector<std::string> warnings;
};

// One attempt to read a frame.
struct ReadResult {
  int index = 0;  // position in the sequence, before --stride
  double stamp_s = 0;
  std::optional<RgbdFrame> frame;  // empty if the files could not be read
  std::string error;               // then why, naming the file
  double decode_ms = 0;            // time spent reading and preparing it
  // Of frames that are offered at a rate (OfferFrames()):
  double waited_ms = 0;    // time that the reader was early
  double queued_ms = 0;    // or the frame waited to be taken
  int dropped_before = 0;  // frames that were not taken in time
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
