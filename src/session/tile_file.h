#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "surfit/mapping/surfel_map.h"

namespace surfit {

// Serialisation of a map as tiles: cubes of 2 m. Surfels are restored bitwise identical and in
// their order.

// Key of the tile of a cell, and file name of a tile in a save.
std::int64_t TileKey(const SurfelCell& cell);
std::string TileName(std::int64_t key, std::int64_t save);

std::string PackTile(const SurfelMap& map, const std::vector<std::int32_t>& cells);
// Appends the surfels of a tile to a map, and returns their number. Throws InputError with `from`
// for invalid bytes.
std::size_t UnpackTile(const std::string& bytes, const std::string& from, SurfelMap* map);

}  // namespace surfit
