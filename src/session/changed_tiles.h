#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "surfit/mapping/surfel_map.h"

namespace surfit {

// A tile whose surfels have changed; without any left it is empty.
struct ChangedTile {
  std::int64_t key = 0;  // TileKey()
  std::string bytes;     // PackTile()
  std::int64_t surfels = 0;
};

// Tells which tiles of a map change from save to save. Fusion leaves the number of its frame with
// each surfel that it changes, and the cells that others leave have fewer.
class ChangedTiles {
 public:
  // Those that have changed since the last call, all by the first: by ascending key. `corrections`
  // counts the changes of surfels that no frame was fused to, Slam::corrections_of_map(), and
  // `last_frame` is the newest that may have been fused.
  std::vector<ChangedTile> Take(const SurfelMap& map, int corrections, int last_frame);

 private:
  std::vector<std::int32_t> counts_;  // of each cell, when it was looked at last
  std::map<std::int64_t, std::vector<std::int32_t>> cells_of_tile_;
  int corrections_ = 0;
  int last_frame_ = 0;
  bool is_first_ = true;
};

}  // namespace surfit
