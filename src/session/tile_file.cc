#include "session/tile_file.h"

#include <cmath>
#include <cstring>

#include "surfit/core/error.h"

namespace surfit {
namespace {

constexpr char kMagic[] = "surfit tile 3\n";
constexpr char kOldMagic[] = "surfit tile 2\n";  // of version 0.1
constexpr std::size_t kMagicBytes = sizeof(kMagic) - 1;
constexpr int kTileCellsAcross = 4;
constexpr int kAxisBits = 20;
constexpr int kFarthest = 1 << (kAxisBits - 1);

int FloorDiv(int a, int b) { return a >= 0 ? a / b : -((b - 1 - a) / b); }

template <typename Block, typename Call>
void ForEachColumn(Block& block, const Call& column) {
  for (auto* coordinates : {block.x, block.y, block.z}) column(coordinates);
  for (auto* normals : {block.nx, block.ny, block.nz}) column(normals);
  for (auto* frames : {block.first_seen_low, block.last_seen_low}) column(frames);
  for (auto* frames : {block.first_seen_high, block.last_seen_high}) column(frames);
  for (auto* shorts : {block.radius, block.confidence, block.red, block.green, block.blue}) {
    column(shorts);
  }
}

// Bytes of a tile. Reading beyond the end throws InputError.
class TileBytes {
 public:
  TileBytes(const std::string& bytes, const std::string& from) : bytes_(bytes), from_(from) {}

  [[noreturn]] void Fail(const char* why) const { throw InputError(from_, ": ", why); }
  void Skip(std::size_t size) { at_ += size; }
  bool AtEnd() const { return at_ == bytes_.size(); }
  void Take(void* data, std::size_t size) {
    if (size > bytes_.size() - at_) Fail("ends too early");
    std::memcpy(data, bytes_.data() + at_, size);
    at_ += size;
  }

 private:
  const std::string &bytes_, &from_;
  std::size_t at_ = 0;
};

struct PlacedBlock {
  SurfelBlock block;
  Eigen::Vector3f positions[SurfelBlock::kCapacity];  // in the world, m
};

PlacedBlock TakeHead(TileBytes* in) {
  PlacedBlock placed;
  SurfelBlock& block = placed.block;
  in->Take(&block.count, sizeof(block.count));
  if (block.count < 0 || block.count > SurfelBlock::kCapacity) in->Fail("has an invalid block");
  in->Take(&block.at_edge, sizeof(block.at_edge));
  return placed;
}

PlacedBlock TakeBlock(TileBytes* in) {
  PlacedBlock placed = TakeHead(in);
  SurfelBlock& block = placed.block;
  in->Take(block.origin, sizeof(block.origin));
  for (const float origin : block.origin) {
    if (!std::isfinite(origin)) in->Fail("has an invalid block");
  }
  ForEachColumn(block, [&](auto* column) { in->Take(column, block.count * sizeof(*column)); });
  for (int k = 0; k < block.count; ++k) placed.positions[k] = block.Position(k);
  return placed;
}

// Version 0.1 had floating-point positions in the world, floating-point confidences and 32-bit
// frame indices.
PlacedBlock TakeOldBlock(TileBytes* in) {
  PlacedBlock placed = TakeHead(in);
  SurfelBlock& block = placed.block;
  constexpr int kCapacity = SurfelBlock::kCapacity;
  float x[kCapacity] = {}, y[kCapacity] = {}, z[kCapacity] = {}, confidence[kCapacity] = {};
  std::int32_t first_seen[kCapacity] = {}, last_seen[kCapacity] = {};
  const auto take = [&](auto* column) { in->Take(column, block.count * sizeof(*column)); };
  for (auto* floats : {x, y, z, confidence}) take(floats);
  for (auto* normals : {block.nx, block.ny, block.nz}) take(normals);
  for (auto* frames : {first_seen, last_seen}) take(frames);
  for (auto* shorts : {block.radius, block.red, block.green, block.blue}) take(shorts);
  for (int k = 0; k < block.count; ++k) {
    placed.positions[k] = {x[k], y[k], z[k]};
    const bool is_valid = placed.positions[k].allFinite() && std::isfinite(confidence[k]) &&
                          first_seen[k] >= 0 && first_seen[k] <= SurfelBlock::kMaxFrame &&
                          last_seen[k] >= 0 && last_seen[k] <= SurfelBlock::kMaxFrame;
    if (!is_valid) in->Fail("has an invalid surfel");
    block.SetConfidence(k, confidence[k]);
    block.SetFirstSeen(k, first_seen[k]);
    block.SetLastSeen(k, last_seen[k]);
  }
  return placed;
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
// surfels at depth edges, its origin, and the surfel columns.
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
      put(block.origin, sizeof(block.origin));
      ForEachColumn(block, [&](const auto* column) { put(column, block.count * sizeof(*column)); });
    }
  }
  return bytes;
}

std::size_t UnpackTile(const std::string& bytes, const std::string& from, SurfelMap* map) {
  TileBytes in(bytes, from);
  const std::string magic = bytes.substr(0, kMagicBytes);
  const bool is_old = magic == kOldMagic;
  if (magic != kMagic && !is_old) in.Fail("does not begin with the signature of a tile");
  in.Skip(kMagicBytes);
  std::uint32_t blocks = 0;
  in.Take(&blocks, sizeof(blocks));
  std::size_t count = 0;
  for (; blocks > 0; --blocks) {
    const PlacedBlock placed = is_old ? TakeOldBlock(&in) : TakeBlock(&in);
    for (int k = 0; k < placed.block.count; ++k) {
      Surfel surfel = placed.block[k];
      surfel.position_in_world = placed.positions[k];
      const std::int32_t id = map->Append(surfel);
      map->block(id / SurfelBlock::kCapacity)
          .Take(id % SurfelBlock::kCapacity, placed.block, k, placed.positions[k]);
    }
    count += placed.block.count;
  }
  if (!in.AtEnd()) in.Fail("has bytes after its end");
  return count;
}

}  // namespace surfit
