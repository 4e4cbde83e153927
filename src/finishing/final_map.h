#pragma once

#include <Eigen/Geometry>
#include <atomic>
#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "finishing/posed_sequence.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

// Called with the number of completed frames and the number of surfels.
using FinalMapProgress = std::function<void(int frames, std::size_t map_points)>;

// Fuses a new map of a sequence with the final poses and the estimated calibration:
//   1. fuses all frames, without moving objects and without `left_out` frames. Rolling shutter is
//      corrected by the motion between the neighbouring poses. Surfels are denser than in tracking.
//   2. removes surfels that were observed about once and only at depth edges, and smooths the
//      others (SmoothMap)
//   3. recolours the surfels from every second frame, at the registered poses of the colour images
//      (RegisterColors, ColorAverage)
// Returns std::nullopt if interrupted. Throws InputError if the sequence cannot be read.
std::optional<SurfelMap> IntegrateFinalMap(const PosedSequence& known,
                                           const std::atomic<bool>& interrupted,
                                           const FinalMapProgress& progress);

struct MapSource {
  const PosedSequence& known;
  std::vector<FrameRange> frames;  // empty: all frames
  int first_frame = 0;             // offset of the frame indices; keeps those of the map ascending
};

// Part of a map: the surfels in a half-open box of the world frame.
struct MapPart {
  Eigen::AlignedBox3f box;
  float margin_m = 0;  // width of the region around the box that is fused, then removed
  std::vector<MapSource> sources;
};

// Fuses a part of a map from all its sequences, like IntegrateFinalMap(). The memory depends on the
// size of the part, the time on the number of frames. `part.sources` must not be empty. Uses the
// fusion options of the first source.
std::optional<SurfelMap> FusePart(const MapPart& part, const std::atomic<bool>& interrupted,
                                  const FinalMapProgress& progress);

}  // namespace surfit
