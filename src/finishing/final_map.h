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
// to the number of fused frames. Fusion has half of the progress, registration and colouring have a
// quarter each. `map_points`: surfels so far. Must not be empty.
using FinalMapProgress = std::function<void(int frames, std::size_t map_points)>;

// Optional steps of the final map.
struct FinalMapSteps {
  bool refine_poses = false;  // register all frames with colour, not only those of step 5
  bool stereo = false;        // step 4
};

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
//   3. registers frames to the map (FramePoses)
//   4. adds surfaces that only colour images show (FindUnmeasuredSurfaces)
//   5. recolours the surfels from every third frame (ColorAverage), at the poses of step 3. Frames
//      of `left_out` give no colours.
// Without `refine_poses`, the trajectory of the result is the given one. Returns std::nullopt if
// interrupted. Throws InputError if the sequence cannot be read. `interrupted` is checked before
// each frame.
std::optional<FinalMap> IntegrateFinalMap(const PosedSequence& known, const FinalMapSteps& steps,
                                          const std::atomic<bool>& interrupted,
                                          const FinalMapProgress& progress);

// Map without the surfels of step 4, which are too inaccurate for tracking.
SurfelMap WithoutStereo(SurfelMap map);

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

// Fuses a part of a map from all its sequences, like IntegrateFinalMap() without the optional
// steps. The memory depends on the size of the part, the time on the number of frames.
// `part.sources` must not be empty; its first source has the fusion options and the sensor for
// SmoothMap(). All sources have poses in the world frame of the part. Returns std::nullopt if
// interrupted. Throws InputError if a sequence cannot be read.
std::optional<SurfelMap> FusePart(const MapPart& part, const std::atomic<bool>& interrupted,
                                  const FinalMapProgress& progress);

}  // namespace surfit
