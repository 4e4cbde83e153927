#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "surfit/geometry/inverse_depth_field.h"
#include "surfit/geometry/trajectory.h"
#include "surfit/io/sequence.h"
#include "surfit/mapping/surfel_map.h"
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
  const DepthCalibration* calibration = nullptr;  // that was found; null: as given
  double color_latency_s = 0;  // by how much colour was found to be earlier than frames have it
};

// Called with the frames that are done, and the surfels that the map has of them.
using FinalMapProgress = std::function<void(int frames, std::size_t map_points)>;

// A map of a sequence, fused anew along the poses that are known in the end, by the calibration
// that was found, without what moves. Depth is brought to the middle of its readout, and colours
// are taken at the moment of their rows, by the motion between the poses before and after. Nothing
// if it is interrupted. Throws InputError if the sequence cannot be read.
std::optional<SurfelMap> FuseAnew(const KnownSequence& known, const std::atomic<bool>& interrupted,
                                  const FinalMapProgress& progress);

}  // namespace surfit
