#pragma once

#include <atomic>
#include <optional>
#include <vector>

#include "finishing/stereo/stereo_keyframe.h"
#include "surfit/core/image.h"
#include "surfit/geometry/sensor.h"
#include "surfit/mapping/fusion.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

struct UnmeasuredSurfaces {
  std::vector<Surfel> surfels;  // with from_stereo
  // Depth images of the keyframes, m. Pixels without measured depth that show these surfels or the
  // map have a depth, other pixels have 0. Empty without any measured depth.
  std::vector<Image<float>> depth_m;
};

// Finds surfaces that colour images show and depth images do not, such as monitors, glossy tables
// and distant walls, by multi-view stereo:
//   1. Each keyframe is matched with other keyframes (MatchDepth()).
//   2. A depth is kept if it agrees within three labels with the depth of three other keyframes. It
//      becomes the mean of these depths. It is dropped if three keyframes measure a surface behind
//      it, or if the map has a surface within 8 % of it.
//   3. The depths of all keyframes are fused (Fusion). Surfels with a confidence below 1 are
//      removed. Surfels are also removed if too many keyframes measure a surface behind them,
//      relative to the number of keyframes without depth at their pixels (kMaxFreeRatio).
// Stereo interpolates surfaces without texture between their borders. All keyframes have the same
// image size, and poses in the world frame of the map. `sensor`: sensor of the frames. Returns
// std::nullopt if interrupted. The result does not depend on the number of threads.
std::optional<UnmeasuredSurfaces> FindUnmeasuredSurfaces(
    const std::vector<StereoKeyframe>& keyframes, const SurfelMap& map, const DepthSensor& sensor,
    const FusionOptions& fusion, const std::atomic<bool>& interrupted);

}  // namespace surfit
