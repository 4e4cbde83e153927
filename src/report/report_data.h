#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "surfit/mapping/surfel_block.h"

namespace surfit {

// Base64 with padding (RFC 4648, section 4).
std::string EncodeBase64(const unsigned char* bytes, std::size_t count);
inline std::string EncodeBase64(const std::string& bytes) {
  return EncodeBase64(reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
}

// The bytes of the values as they lie in memory: little endian on all processors that we know, and
// in every browser.
template <typename T>
std::string EncodeBase64(const std::vector<T>& values) {
  return EncodeBase64(reinterpret_cast<const unsigned char*>(values.data()),
                      values.size() * sizeof(T));
}

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

// All that the page shows of one run, read from its output folder: label (the folder), summary
// (summary.json, with judged_views where surfit_evaluate_views wrote views.json), frames (the text
// of frames.csv), poses (poses.json) with its views' pictures as data URLs, and map (PackMap).
// Throws InputError naming the file that is missing or broken.
nlohmann::ordered_json ReadRun(const std::string& folder, std::size_t max_points);

}  // namespace surfit
