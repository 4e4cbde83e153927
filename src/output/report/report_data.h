#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "surfit/geometry/trajectory.h"
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

// At most max_points of the surfels, evenly spread over their order (files of maps are in order of
// space), and so that any first part of them is evenly spread too. Those with a coordinate that is
// not finite are left out.
std::vector<Surfel> EvenlySpread(const std::vector<Surfel>& surfels, std::size_t max_points);

// EvenlySpread() surfels as JSON for the page, with base64 of little endian arrays:
//   points, shown        how many there are, and how many of them follow
//   origin, extent       metres: position = origin + extent * position / 65535
//   position             3 x uint16 a surfel
//   normal               3 x int8, of length 127
//   color                3 x uint8
//   confidence           float32
//   first_seen, last_seen  int32
//   max_radius           of the shown surfels, metres
//   radius               uint16: radius = max_radius * radius / 65535
nlohmann::ordered_json PackMap(const std::vector<Surfel>& surfels, std::size_t max_points);

// Distances as base64 of uint16 in tenths of a millimetre; 65535 for kFarFromMap and more.
std::string PackDistances(const std::vector<float>& distances_m);

// What the page calls folders: the last parts of their paths, as many as tell them apart.
std::vector<std::string> ShortNames(const std::vector<std::string>& folders);

// What a folder holds of a run of surfit_slam, or of one that surfit_refine has refined.
// NOLINTNEXTLINE(bugprone-exception-escape): JSON is moved without copies
struct ReportedRun {
  // label (empty); summary (summary.json, with judged_views where surfit_evaluate --what=views
  // wrote views.json, or else refinement.json); frames and loops (the texts of frames.csv and
  // loops.csv, or empty); poses (poses.json) with its pictures as data URLs.
  nlohmann::ordered_json page;
  std::vector<Surfel> surfels;  // map.ply
  Trajectory trajectory;        // of poses.json
};

// With at most so many thumbnails, evenly spread. Throws InputError naming the file that is missing
// or broken.
ReportedRun ReadRun(const std::string& folder, std::size_t max_thumbnails);

}  // namespace surfit
