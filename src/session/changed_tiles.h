#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "surfit/mapping/surfel_map.h"

namespace surfit {

// Tile with changed surfels. Empty `bytes`: no surfels are left.
struct ChangedTile {
  std::int64_t key = 0;  // TileKey()
  std::string bytes;     // PackTile()
  std::int64_t surfels = 0;
};

// Finds the tiles that change between saves, by `last_seen` of the surfels and the number of
// surfels per cell. Always pass the same map object. Other changes of the map are only found if
// `corrections` changes.
class ChangedTiles {
 public:
  // Returns the tiles that have changed since the last call, by ascending key. The first call, and
  // a call with other `corrections`, return all tiles.
  // - corrections: Slam::corrections_of_map()
  // - last_frame: index of the newest frame, at least the largest last_seen
  std::vector<ChangedTile> Take(const SurfelMap& map, int corrections, int last_frame);

 private:
  std::vector<std::int32_t> counts_;
  std::map<std::int64_t, std::vector<std::int32_t>> cells_of_tile_;
  int corrections_ = 0;
  int last_frame_ = 0;
  bool is_first_ = true;
};

}  // namespace surfit
