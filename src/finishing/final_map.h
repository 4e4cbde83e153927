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

// Called on the calling thread after each frame of a pass, and at the end. `frames`: progress, up
// to about the number of frames. Fusion has two thirds of the progress, recolouring has one third.
// `map_points`: surfels so far. Must not be empty.
using FinalMapProgress = std::function<void(int frames, std::size_t map_points)>;

struct FinalMap {
  SurfelMap map;
  Trajectory trajectory;  // WithFinalPoses()
};

// Builds the final map of a sequence from the final poses and the estimated calibration:
//   1. fuses all frames except `left_out`, without moving objects and with rolling-shutter
//      correction. Frames without a pose and unreadable frames are skipped. Surfels are denser than
//      in tracking.
//   2. removes noise at depth edges if more than max_inactive_frames frames were fused, and smooths
//      the map (SmoothMap)
//   3. recolours the surfels from every third frame (ColorAverage), at poses that are registered to
//      the map (FramePoses).
// With `refine_poses`, step 3 registers all frames with colour. `left_out` has no effect on this.
// Otherwise the trajectory of the result is the given one. Returns std::nullopt if interrupted.
// Throws InputError if the sequence cannot be read. `interrupted` is checked before each frame.
std::optional<FinalMap> IntegrateFinalMap(const PosedSequence& known, bool refine_poses,
                                          const std::atomic<bool>& interrupted,
                                          const FinalMapProgress& progress);

// Sequence of a map, or ranges of its frames.
struct MapSource {
  const PosedSequence& known;      // must outlive the MapSource
  std::vector<FrameRange> frames;  // see ReopenSequence(); empty: all frames
  int first_frame = 0;  // offset added to frame indices, so that sources do not share indices
};

// Part of a map: the surfels in a half-open box of the world frame.
struct MapPart {
  Eigen::AlignedBox3f box;  // m
  float margin_m = 0;       // width of the region around the box that is fused, then removed
  std::vector<MapSource> sources;
};

// Fuses a part of a map from all its sequences, like IntegrateFinalMap(), and registers every third
// frame. The memory depends on the
// size of the part, the time on the number of frames. `part.sources` must not be empty; its first
// source has the fusion options and the sensor for SmoothMap(). All sources have poses in the world
// frame of the part. Returns std::nullopt if interrupted. Throws InputError if a sequence cannot be
// read.
std::optional<SurfelMap> FusePart(const MapPart& part, const std::atomic<bool>& interrupted,
                                  const FinalMapProgress& progress);

}  // namespace surfit
