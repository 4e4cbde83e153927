#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "finishing/found_sensor.h"
#include "surfit/frame/frame_source.h"
#include "surfit/geometry/trajectory.h"
#include "surfit/io/sequence.h"
#include "surfit/slam/slam.h"

namespace surfit {

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
