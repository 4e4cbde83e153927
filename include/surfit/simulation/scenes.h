#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "surfit/simulation/scene.h"

namespace surfit {

// The names MakeScene() knows:
//   room          a furnished room of 4 to 8 m; its size, furniture and colours vary with the seed
//   three_rooms   three such rooms joined by doorways; a path walks through them and back in about
//                 1500 frames, and then again
//   three_planes  floor and two walls that meet at right angles in (0, 0, 0)
//   wall          the plane y = 2 m, textured
//   sphere        a ball of radius 0.5 m at (0, 2, 1) above the floor z = 0
//   corridor      floor, ceiling (z = 2.4 m) and two walls (x = -1 and 1 m), endless along y
// All have z up; all but the rooms are the same for every seed, apart from their textures.
std::vector<std::string> SceneNames();

// Throws InputError that lists the names, for a name that is none of them.
Scene MakeScene(const std::string& name, std::uint64_t seed = 1);

}  // namespace surfit
