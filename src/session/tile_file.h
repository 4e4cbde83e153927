#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "surfit/mapping/surfel_map.h"

namespace surfit {

// Serialisation of a map as tiles: cubes of 2 m. Surfels are restored bitwise identical and in
// their order.

// Key of the tile of a cell, unique in the map.
std::int64_t TileKey(const SurfelCell& cell);
// File name "X_Y_Z.SAVE.tile" of a tile in a save. X, Y and Z are tile coordinates.
std::string TileName(std::int64_t key, std::int64_t save);

// Serialises the surfels of some cells, which are given by index in the map.
std::string PackTile(const SurfelMap& map, const std::vector<std::int32_t>& cells);
// Appends the surfels of a tile to a map, and returns their number. Throws InputError with `from`
// for invalid bytes. The map may then have a part of the surfels.
std::size_t UnpackTile(const std::string& bytes, const std::string& from, SurfelMap* map);

}  // namespace surfit
