#include "session/tile_rows.h"

#include <filesystem>
#include <set>
#include <vector>

#include "session/tile_file.h"

namespace surfit {

namespace fs = std::filesystem;

std::map<std::int64_t, TileRow> ReadTileRows(Database* database) {
  std::map<std::int64_t, TileRow> tiles;
  ForEachIntact(database, "tiles", [&](RowReader* row) {
    const TileRow tile = TakeTile(row);
    tiles[tile.key] = tile;
  });
  return tiles;
}

void RemoveStrayTiles(const std::string& folder, const std::map<std::int64_t, TileRow>& tiles) {
  std::set<std::string> known;
  for (const auto& [key, tile] : tiles) known.insert(TileName(key, tile.save));
  std::vector<fs::path> strays;
  for (const auto& entry : fs::directory_iterator(TilesOf(folder))) {
    const bool is_tile = entry.path().extension() == ".tile";
    if (is_tile && known.count(entry.path().filename()) == 0) strays.push_back(entry.path());
  }
  std::error_code none;
  for (const fs::path& stray : strays) fs::remove(stray, none);
}

}  // namespace surfit
