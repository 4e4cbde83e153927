#pragma once

#include <string>

#include "surfit/mapping/surfel_map.h"

namespace surfit {

// Writes the map as binary little endian PLY, atomically, one vertex a surfel:
// float x y z nx ny nz, uchar red green blue, float radius confidence, int first_seen last_seen
// (metres, world frame, frame indices). Opens in CloudCompare, MeshLab and Open3D.
// Throws InputError naming the file if it cannot be written.
void WriteSurfelPly(const SurfelMap& map, const std::string& path);

}  // namespace surfit
