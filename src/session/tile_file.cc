#include "session/tile_file.h"

#include <cmath>
#include <cstring>

#include "surfit/core/error.h"

namespace surfit {
namespace {

constexpr char kMagic[] = "surfit tile 2\n";
constexpr std::size_t kHeadBytes = sizeof(kMagic) - 1 + sizeof(std::uint32_t);
constexpr int kTileCellsAcross = 4;
constexpr int kAxisBits = 20;
constexpr int kFarthest = 1 << (kAxisBits - 1);

int FloorDiv(int a, int b) { return a >= 0 ? a / b : -((b - 1 - a) / b); }

template <typename Block, typename Call>
void ForEachColumn(Block& block, const Call& column) {
  for (auto* floats : {block.x, block.y, block.z, block.confidence}) column(floats);
  for (auto* normals : {block.nx, block.ny, block.nz}) column(normals);
  for (auto* frames : {block.first_seen, block.last_seen}) column(frames);
  for (auto* shorts : {block.radius, block.red, block.green, block.blue}) column(shorts);
}

bool IsSane(const SurfelBlock& block, int k) {
  for (const float number : {block.x[k], block.y[k], block.z[k], block.confidence[k]}) {
    if (!std::isfinite(number)) return false;
  }
  return true;
}

}  // namespace

std::int64_t TileKey(const SurfelCell& cell) {
  std::int64_t key = 0;
  for (const int cube : SurfelMap::CubeOf(cell)) {
    key = key << kAxisBits | (FloorDiv(cube, kTileCellsAcross) + kFarthest);
  }
  return key;
}

std::string TileName(std::int64_t key, std::int64_t save) {
  constexpr std::int64_t kMask = 2 * kFarthest - 1;
  const auto axis = [&](int i) { return (key >> ((2 - i) * kAxisBits) & kMask) - kFarthest; };
  return Concat(axis(0), "_", axis(1), "_", axis(2), ".", save, ".tile");
}

// Format: signature, number of blocks, blocks. A block has the surfel count, the bit mask of
// surfels at depth edges, and the surfel columns.
std::string PackTile(const SurfelMap& map, const std::vector<std::int32_t>& cells) {
  std::string bytes(kMagic);
  std::uint32_t blocks = 0;
  for (const std::int32_t cell : cells) blocks += map.cell(cell).blocks.size();
  const auto put = [&](const void* data, std::size_t size) {
    bytes.append(static_cast<const char*>(data), size);
  };
  put(&blocks, sizeof(blocks));
  for (const std::int32_t cell : cells) {
    for (const std::int32_t b : map.cell(cell).blocks) {
      const SurfelBlock& block = map.block(b);
      put(&block.count, sizeof(block.count));
      put(&block.at_edge, sizeof(block.at_edge));
      ForEachColumn(block, [&](const auto* column) { put(column, block.count * sizeof(*column)); });
    }
  }
  return bytes;
}

std::size_t UnpackTile(const std::string& bytes, const std::string& from, SurfelMap* map) {
  const auto fail = [&](const char* why) { throw InputError(from, ": ", why); };
  if (bytes.size() < kHeadBytes || bytes.compare(0, sizeof(kMagic) - 1, kMagic) != 0) {
    fail("does not begin with the signature of a tile");
  }
  std::size_t at = sizeof(kMagic) - 1, count = 0;
  const auto take = [&](void* data, std::size_t size) {
    if (size > bytes.size() - at) fail("ends too early");
    std::memcpy(data, bytes.data() + at, size);
    at += size;
  };
  std::uint32_t blocks = 0;
  take(&blocks, sizeof(blocks));
  for (; blocks > 0; --blocks) {
    SurfelBlock block;
    take(&block.count, sizeof(block.count));
    if (block.count < 0 || block.count > SurfelBlock::kCapacity) fail("has an invalid block");
    take(&block.at_edge, sizeof(block.at_edge));
    ForEachColumn(block, [&](auto* column) { take(column, block.count * sizeof(*column)); });
    for (int k = 0; k < block.count; ++k) {
      if (!IsSane(block, k)) fail("has an invalid surfel");
      const std::int32_t id = map->Append(block[k]);
      map->block(id / SurfelBlock::kCapacity).Take(id % SurfelBlock::kCapacity, block, k);
    }
    count += block.count;
  }
  if (at != bytes.size()) fail("has bytes after its end");
  return count;
}

}  // namespace surfit
