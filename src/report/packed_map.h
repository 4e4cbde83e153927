#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "surfit/mapping/surfel.h"

namespace surfit {

// At most max_points of the surfels as JSON for the page, evenly spread over their order (files of
// maps are in order of space), and so that any first part of them is evenly spread too, with base64
// of little endian arrays:
//   points, shown        how many there are, and how many of them follow
//   origin, extent       metres: position = origin + extent * position / 65535
//   position             3 x uint16 a surfel
//   normal               3 x int8, of length 127
//   color                3 x uint8
//   confidence           float32
//   first_seen, last_seen  int32
//   radius               median of the shown surfels', metres
// Surfels with a coordinate that is not finite are left out of `shown`.
nlohmann::ordered_json PackMap(const std::vector<Surfel>& surfels, std::size_t max_points);

}  // namespace surfit
