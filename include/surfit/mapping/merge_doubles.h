#pragma once

#include <cstddef>
#include <limits>

#include "surfit/mapping/fusion.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

// Which surfels may be doubles.
struct DoublesOptions {
  // The older one was last seen more than so many frames before the newer one was first seen: those
  // were never fused together.
  int frames_apart = 100;
  int newer_since = std::numeric_limits<int>::min();  // the newer one was first seen then or later
};

// Merges surfaces that were mapped twice, once the map has been moved so that they coincide. A
// surfel is merged with the nearest older one that is the same by the gates of fusion, measured
// along and across its own normal, as nobody looks at both: a surfel stands for what is within
// their radius. The older one stays, as the average of both by their
// confidences; the newer one is removed. Returns how many were. The result does not depend on the
// number of threads. Ids change.
std::size_t MergeDoubles(const FusionOptions& options, const DoublesOptions& doubles,
                         SurfelMap* map);

}  // namespace surfit
