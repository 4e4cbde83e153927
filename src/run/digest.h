#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "surfit/geometry/trajectory.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

// The 64-bit FNV-1a hash (Fowler, Noll, Vo) of a trajectory's and a map's bytes, in hexadecimal.
std::string Digest(const Trajectory& trajectory, const SurfelMap& map);

}  // namespace surfit
