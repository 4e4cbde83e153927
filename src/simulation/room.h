#pragma once

#include <cstdint>

#include "surfit/simulation/scene.h"

namespace surfit {

// A furnished room; what stands where, its size and its colours vary with the seed.
Scene MakeRoom(std::uint64_t seed);

// Three such rooms in a row along x with doorways between them, and a way through all of them and
// back (Scene::route).
Scene MakeThreeRooms(std::uint64_t seed);

}  // namespace surfit
