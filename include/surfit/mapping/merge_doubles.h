#pragma once

#include <cstddef>

#include "surfit/mapping/fusion.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

// Merges surfaces that were mapped twice, once the map has been moved so that they coincide. A
// surfel is merged with the nearest one that it belongs to by the gates of fusion (a surfel stands
// for what is within their radius), and that was last seen more than `frames_apart` frames before
// the other was first seen: those were never fused together. The older one stays, as the average
// of both by their confidences; the newer one is removed. Returns how many were. The result does
// not depend on the number of threads. Ids change.
std::size_t MergeDoubles(const FusionOptions& options, int frames_apart, SurfelMap* map);

}  // namespace surfit
