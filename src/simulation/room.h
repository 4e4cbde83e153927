#pragma once

#include <cstdint>

#include "surfit/simulation/scene.h"

namespace surfit {

// A furnished room; what stands where, its size and its colours vary with the seed.
Scene MakeRoom(std::uint64_t seed);

}  // namespace surfit
