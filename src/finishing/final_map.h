#pragma once

#include <Eigen/Geometry>
#include <atomic>
#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "finishing/known_sequence.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

// Called with the frames that are done, and the surfels that the map has of them.
using FinalMapProgress = std::function<void(int frames, std::size_t map_points)>;

// A map of a sequence, fused anew along the poses that are known in the end, by the calibration
// that was found, without what moves. Depth is brought to the middle of its readout, and colours
// are taken at the moment of their rows, by the motion between the poses before and after. Surfels
// are closer to each other than in a map to track by, those that were seen about once and only at
// depth edges are left out, and the others are smoothed (SmoothMap). In the end colours are taken
// anew, from where each second frame's own colours say that they were seen (RegisterColors,
// ColorAverage). Nothing if it is interrupted. Throws InputError if the sequence cannot be read.
std::optional<SurfelMap> FuseAnew(const KnownSequence& known, const std::atomic<bool>& interrupted,
                                  const FinalMapProgress& progress);

// What of a sequence is fused.
struct MapSource {
  const KnownSequence& known;
  std::vector<FrameRange> frames;  // empty: all
  int first_frame = 0;             // added to its frames' indices, so that the map's are ascending
};

// A part of a map: what lies in a box of the world, half-open, seen by frames of some sequences.
struct MapPart {
  Eigen::AlignedBox3f box;
  float margin_m = 0;  // around it is fused as well, and left out in the end
  std::vector<MapSource> sources;
};

// The same of a part, of one sequence after the other: memory goes by what is in the box, time by
// the frames. There must be a source.
std::optional<SurfelMap> FusePart(const MapPart& part, const std::atomic<bool>& interrupted,
                                  const FinalMapProgress& progress);

}  // namespace surfit
