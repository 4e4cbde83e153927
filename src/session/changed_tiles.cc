#include "session/changed_tiles.h"

#include <algorithm>
#include <set>
#include <utility>

#include "session/tile_file.h"

namespace surfit {
namespace {

std::int32_t CountOf(const SurfelMap& map, const SurfelCell& cell) {
  if (cell.blocks.empty()) return 0;
  const auto full = static_cast<std::int32_t>(cell.blocks.size()) - 1;
  return full * SurfelBlock::kCapacity + map.block(cell.blocks.back()).count;
}

bool WasSeenAfter(int frame, const SurfelMap& map, const SurfelCell& cell) {
  return std::any_of(cell.blocks.begin(), cell.blocks.end(), [&](std::int32_t b) {
    const SurfelBlock& block = map.block(b);
    for (int k = 0; k < block.count; ++k) {
      if (block.LastSeen(k) > frame) return true;
    }
    return false;
  });
}

}  // namespace

std::vector<ChangedTile> ChangedTiles::Take(const SurfelMap& map, int corrections, int last_frame) {
  const bool all = is_first_ || corrections != corrections_;
  std::set<std::int64_t> changed;
  for (std::int32_t c = 0; c < map.cell_count(); ++c) {
    const SurfelCell& cell = map.cell(c);
    const std::int64_t key = TileKey(cell);
    if (c >= static_cast<std::int32_t>(counts_.size())) {
      counts_.push_back(0);
      cells_of_tile_[key].push_back(c);
    }
    const std::int32_t count = CountOf(map, cell);
    if (all || count != counts_[c] || WasSeenAfter(last_frame_, map, cell)) changed.insert(key);
    counts_[c] = count;
  }
  is_first_ = false;
  corrections_ = corrections;
  last_frame_ = last_frame;
  std::vector<ChangedTile> tiles;
  for (const std::int64_t key : changed) {
    const std::vector<std::int32_t>& cells = cells_of_tile_[key];
    ChangedTile tile = {key, {}, 0};
    for (const std::int32_t c : cells) tile.surfels += counts_[c];
    if (tile.surfels > 0) tile.bytes = PackTile(map, cells);
    tiles.push_back(std::move(tile));
  }
  return tiles;
}

}  // namespace surfit
