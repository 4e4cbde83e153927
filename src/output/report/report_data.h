#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "surfit/geometry/trajectory.h"
#include "surfit/mapping/surfel_block.h"

namespace surfit {

// Base64 with padding (RFC 4648).
std::string EncodeBase64(const unsigned char* bytes, std::size_t count);
inline std::string EncodeBase64(const std::string& bytes) {
  return EncodeBase64(reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
}

// Base64 of the memory of the values, little endian on all supported processors.
template <typename T>
std::string EncodeBase64(const std::vector<T>& values) {
  return EncodeBase64(reinterpret_cast<const unsigned char*>(values.data()),
                      values.size() * sizeof(T));
}

// Selects at most `max_points` surfels, evenly spread over the input order, which is spatial in map
// files. Every prefix is evenly spread, too. Surfels with non-finite positions are omitted, not
// replaced.
std::vector<Surfel> EvenlySpread(const std::vector<Surfel>& surfels, std::size_t max_points);

// Result of EvenlySpread() as JSON for the page, with base64 of little-endian arrays:
//   points, shown        number of surfels in the map, and in this object
//   origin, extent       m: position = origin + extent * position / 65535
//   position             3 x uint16 per surfel
//   normal               3 x int8, unit vector times 127
//   color                3 x uint8
//   confidence           float32
//   first_seen, last_seen  int32
//   max_radius           largest radius of the shown surfels, m
//   radius               uint16: radius = max_radius * radius / 65535
nlohmann::ordered_json PackMap(const std::vector<Surfel>& surfels, std::size_t max_points);

// Distances as base64 of uint16, in units of 0.1 mm. 65535: kFarFromMap or more, or NaN.
std::string PackDistances(const std::vector<float>& distances_m);

// Unique suffixes of the folder paths, with the smallest common number of folder names. In the
// order of `folders`. Equal folders get equal names.
std::vector<std::string> ShortNames(const std::vector<std::string>& folders);

// Data of a run of surfit_slam or surfit_refine for the report.
// NOLINTNEXTLINE(bugprone-exception-escape): JSON is moved without copies
struct ReportedRun {
  // Keys:
  // - label: empty
  // - summary: summary.json, or refinement.json. If views.json of surfit_evaluate exists, it is the
  //   key judged_views of `summary`.
  // - frames, loops: text of frames.csv and loops.csv, or empty
  // - poses: poses.json with pictures as data URLs
  nlohmann::ordered_json page;
  std::vector<Surfel> surfels;  // map.ply
  Trajectory trajectory;
};

// Reads the folder of a run, with at most `max_thumbnails` evenly spread thumbnails. Throws
// InputError with the path of a missing or invalid file; loops.csv, views.json and the thumbnails
// may be missing. Also throws for a pose more than 1e9 m from the origin. Requires max_thumbnails
// >= 1.
ReportedRun ReadRun(const std::string& folder, std::size_t max_thumbnails);

}  // namespace surfit
