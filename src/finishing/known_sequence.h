#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "surfit/frame/frame_source.h"
#include "surfit/geometry/inverse_depth_field.h"
#include "surfit/geometry/sensor.h"
#include "surfit/geometry/trajectory.h"
#include "surfit/io/sequence.h"
#include "surfit/slam/slam.h"

namespace surfit {

// What a run has found of the sensor, beyond what was given.
struct FoundSensor {
  std::optional<DepthCalibration> calibration;  // none: as given
  double color_latency_s = 0;  // by how much colour was found to be earlier than frames have it

  // The sensor that the frames are seen by.
  DepthSensor Of(DepthSensor given) const;
  // A frame as it was given, to depth and the moment of colour as they were found.
  void Correct(RgbdFrame* frame) const;
};

// A sentence where a depth camera that was found is farther from the given one than what is known
// of such sensors leaves room for, so that the given one may be that of another sensor, or another
// size of image: one in a hundred right ones is. Empty otherwise. Of undistorted and downsampled
// images with the given field applied.
std::string DoubtOfGiven(const DepthSensor& given, const DepthCalibration& found);

// What is known of a sequence in the end.
struct KnownSequence {
  const SequenceOptions& sequence;  // as the run read it
  const SlamOptions& slam;          // how frames are preprocessed and fused
  const Trajectory& trajectory;
  const std::vector<int>& frames;  // of the trajectory's poses: the frames' indices, ascending
  const std::set<int>& left_out;   // of these frames, those that are not to be in the map
  // What moves in frames, FrameReport::moving, by their indices.
  const std::map<int, Image<std::uint8_t>>& moving;
  FoundSensor found;
};

// Frames of a sequence, by their indices, both inclusive.
struct FrameRange {
  int first = 0, last = 0;
};

// Opens a sequence, reading a few frames ahead: all that the options say, or of these only some
// ranges, ascending, apart from each other and at least one.
std::unique_ptr<FrameSource> OpenAgain(const SequenceOptions& sequence,
                                       const std::vector<FrameRange>& ranges = {});

// Reads the frames that have a pose from the source, which may have other sizes of images, and
// calls with the pose's place in the trajectory and the frame as it was measured, without what
// moves. Returns false if it is interrupted.
bool ReadKnownFrames(const KnownSequence& known, FrameSource* source,
                     const std::atomic<bool>& interrupted,
                     const std::function<void(std::size_t pose, RgbdFrame frame)>& call);

}  // namespace surfit
