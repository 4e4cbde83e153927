#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "surfit/mapping/surfel_map.h"

namespace surfit {

// A map in cubes of 2 m, the tiles, each as bytes: what its cells hold, to the bit, in their order.

// Which tile a cell is of, as a number by which tiles can be sorted, and its name in files.
std::int64_t TileKey(const SurfelCell& cell);
std::string TileName(std::int64_t key, std::int64_t save);

// The surfels of these cells.
std::string PackTile(const SurfelMap& map, const std::vector<std::int32_t>& cells);
// Adds them to a map. Throws InputError naming where the bytes are from if they are no such tile.
// Returns how many there are.
std::size_t UnpackTile(const std::string& bytes, const std::string& from, SurfelMap* map);

}  // namespace surfit
