#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "session/schema.h"

namespace surfit {

// Tiles of the last save by key. Throws InputError if a row is damaged.
std::map<std::int64_t, TileRow> ReadTileRows(Database* database);

// Removes the files of all other tiles: tiles of uncommitted saves, and replaced tiles.
void RemoveStrayTiles(const std::string& folder, const std::map<std::int64_t, TileRow>& tiles);

}  // namespace surfit
