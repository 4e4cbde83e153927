#pragma once

#include <string>

#include "surfit/geometry/trajectory.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

// Writes map_color.png, map_normals.png, map_confidence.png and map_last_seen.png into the
// directory: each a sheet of four views of the map, from above, obliquely from a bird's place, from
// the first camera pulled back a little, and from the camera of the path that looks most elsewhere.
// Up is the mean of the cameras' upward (-y) axes, then that of the surfels that look that way, so
// any world frame will do.
//
// Surfels that face away are not drawn: the ceiling and the near walls open by themselves.
// map_confidence shows all surfels, the other sheets only those of confidence >= DustConfidence().
// Normals are coloured (1 + n) / 2 for n in the world frame, x red, y green, z blue.
//
// An empty map gives pictures that say so. Throws InputError where a file cannot be written.
void WriteMapPictures(const SurfelMap& map, const Trajectory& camera_path,
                      const std::string& directory);

// Below this confidence a surfel is taken for dust: 3 (about as many central observations), or a
// tenth of the map's 90 % quantile where that is less, as after few frames. 0 for an empty map.
float DustConfidence(const SurfelMap& map);

}  // namespace surfit
