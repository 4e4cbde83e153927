#include "session/tile_file.h"

#include <gtest/gtest.h>

#include <limits>
#include <numeric>
#include <random>

#include "mapping/random_surfel.h"
#include "mapping/same_map.h"
#include "testing/matchers.h"

namespace surfit::testing {
namespace {

SurfelMap SomeMap() {
  std::mt19937_64 rng(3);
  SurfelMap map;
  for (int i = 0; i < 500; ++i) map.Append(RandomSurfel(&rng));
  return map;
}

std::vector<std::int32_t> AllCells(const SurfelMap& map) {
  std::vector<std::int32_t> cells(map.cell_count());
  std::iota(cells.begin(), cells.end(), 0);
  return cells;
}

// A tile of version 0.1: columns of floating-point positions and confidences, and of 32-bit frames.
std::string PackOld(const SurfelMap& map) {
  std::string bytes = "surfit tile 2\n";
  const auto put = [&](const auto& value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
  };
  std::uint32_t blocks = 0;
  for (const std::int32_t cell : AllCells(map)) blocks += map.cell(cell).blocks.size();
  put(blocks);
  for (const std::int32_t cell : AllCells(map)) {
    for (const std::int32_t b : map.cell(cell).blocks) {
      const SurfelBlock& block = map.block(b);
      const auto column = [&](const auto& value_of) {
        for (int k = 0; k < block.count; ++k) put(value_of(k));
      };
      put(block.count);
      put(block.at_edge);
      for (int i = 0; i < 3; ++i) column([&](int k) -> float { return block.Position(k)[i]; });
      column([&](int k) -> float { return block.Confidence(k); });
      column([&](int k) { return block.nx[k]; });
      column([&](int k) { return block.ny[k]; });
      column([&](int k) { return block.nz[k]; });
      column([&](int k) -> std::int32_t { return block.FirstSeen(k); });
      column([&](int k) -> std::int32_t { return block.LastSeen(k); });
      column([&](int k) { return block.radius[k]; });
      column([&](int k) { return block.red[k]; });
      column([&](int k) { return block.green[k]; });
      column([&](int k) { return block.blue[k]; });
    }
  }
  return bytes;
}

TEST(TileFile, RestoresSurfels) {
  const SurfelMap map = SomeMap();
  SurfelMap restored;
  EXPECT_EQ(UnpackTile(PackTile(map, AllCells(map)), "x", &restored), map.size());
  ExpectSameMap(restored, map);
}

TEST(TileFile, ReadsTilesOfVersion01) {
  const SurfelMap map = SomeMap();
  SurfelMap restored;
  EXPECT_EQ(UnpackTile(PackOld(map), "x", &restored), map.size());
  ExpectSameMap(restored, map);
}

TEST(TileFile, RejectsInvalidBytes) {
  const SurfelMap map = SomeMap();
  for (const std::string& bytes : {PackTile(map, AllCells(map)), PackOld(map)}) {
    SurfelMap restored;
    const auto unpack = [&](const std::string& changed) {
      return [&, changed] { UnpackTile(changed, "some.tile", &restored); };
    };
    ExpectInputError(unpack(bytes + "x"), Names("some.tile"));
    ExpectInputError(unpack(bytes.substr(0, bytes.size() - 1)), Names("some.tile"));
    ExpectInputError(unpack("x" + bytes.substr(1)), Names("some.tile"));
    std::string infinite = bytes;  // the first number after the head and the first block's head
    const float infinity = std::numeric_limits<float>::infinity();
    infinite.replace(14 + 4 + 4 + 8, sizeof(infinity), reinterpret_cast<const char*>(&infinity),
                     sizeof(infinity));
    ExpectInputError(unpack(infinite), Names("some.tile"));
  }
}

}  // namespace
}  // namespace surfit::testing
