#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "session/schema.h"

namespace surfit {

// Tiles of the last save by key. Throws InputError if a row is damaged.
std::map<std::int64_t, TileRow> ReadTileRows(Database* database);

// Removes all other tile files: replaced tiles, and tiles of uncommitted saves. `tiles`: result of
// ReadTileRows(). The session must be locked. Files that cannot be removed are skipped.
void RemoveStrayTiles(const std::string& folder, const std::map<std::int64_t, TileRow>& tiles);

}  // namespace surfit
