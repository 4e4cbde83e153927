#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "session/schema.h"

namespace surfit {

// The tiles of the last save, by their keys. Throws InputError if a row is damaged.
std::map<std::int64_t, TileRow> ReadTileRows(Database* database);

// Removes the files of all other tiles: of saves that were not committed, or that were superseded.
void RemoveStrayTiles(const std::string& folder, const std::map<std::int64_t, TileRow>& tiles);

}  // namespace surfit
