#pragma once

#include <string>
#include <vector>

#include "surfit/mapping/surfel_map.h"

namespace surfit {

// Writes the map as binary little endian PLY, atomically, one vertex a surfel:
// float x y z nx ny nz, uchar red green blue, float radius confidence, int first_seen last_seen
// (metres, world frame, frame indices). Opens in CloudCompare, MeshLab and Open3D.
// Throws InputError naming the file if it cannot be written.
void WriteSurfelPly(const SurfelMap& map, const std::string& path);

// Reads such a file: all of these properties must be there, in any order and of any scalar type.
// Throws InputError naming the file and what is wrong with it.
std::vector<Surfel> ReadSurfelPly(const std::string& path);

}  // namespace surfit
