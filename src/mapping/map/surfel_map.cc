#include "surfit/mapping/surfel_map.h"

#include <algorithm>
#include <cmath>

#include "surfit/core/error.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

// A cell key has one index of kAxisBits bits per axis. Index 0 is kFarthest cubes from the origin
// in the negative direction.
constexpr int kAxisBits = 21;
constexpr int kFarthest = 1 << (kAxisBits - 1);
static_assert(kFarthest * SurfelMap::kCellSize == SurfelMap::kFarthest_m);

// Index of the cube that contains the coordinate x, along one axis. Coordinates beyond the index
// range belong to the outermost cube.
inline float CubeIndex(float x) {
  constexpr auto kMost = static_cast<float>(kFarthest);
  const float index = std::floor(x / SurfelMap::kCellSize + 0.5f);
  return std::max(-kMost, std::min(index, kMost - 1));
}

// Key of the cell that contains the position.
std::uint64_t CellKey(const Eigen::Vector3f& position_in_world) {
  std::uint64_t key = 0;
  for (const float x : position_in_world) {
    key = key << kAxisBits |
          static_cast<std::uint64_t>(static_cast<std::int64_t>(CubeIndex(x)) + kFarthest);
  }
  return key;
}

}  // namespace

Eigen::Vector3i SurfelMap::CubeOf(const SurfelCell& cell) {
  Eigen::Vector3i cube;
  for (int axis = 0; axis < 3; ++axis) {
    const std::uint64_t index = cell.key >> ((2 - axis) * kAxisBits) & (2 * kFarthest - 1);
    cube[axis] = static_cast<int>(index) - kFarthest;
  }
  return cube;
}

std::vector<std::int32_t> SurfelMap::Ids() const {
  std::vector<std::int32_t> ids;
  ids.reserve(size_);
  for (const SurfelCell& cell : cells_) {
    for (const std::int32_t b : cell.blocks) {
      for (int k = 0; k < block(b).count; ++k) ids.push_back(b * SurfelBlock::kCapacity + k);
    }
  }
  return ids;
}

std::int32_t SurfelMap::CellAt(const Eigen::Vector3f& position_in_world) {
  const std::uint64_t key = CellKey(position_in_world);
  const auto [at, is_new] = cell_of_key_.try_emplace(key, cell_count());
  if (is_new) cells_.emplace_back().key = key;
  return at->second;
}

void SurfelMap::AddBlock(std::int32_t cell) {
  if (free_blocks_.empty()) {
    blocks_.emplace_back();
    free_blocks_.push_back(static_cast<std::int32_t>(blocks_.size()) - 1);
  }
  const std::int32_t added = free_blocks_.back();
  free_blocks_.pop_back();
  block(added) = SurfelBlock();
  block(added).cell = cell;
  const Eigen::Vector3i cube = CubeOf(cells_[cell]);
  for (int axis = 0; axis < 3; ++axis) {
    block(added).origin[axis] = kCellSize * (static_cast<float>(cube[axis]) - 1.f);
  }
  cells_[cell].blocks.push_back(added);
}

// Allocates an id for a surfel and updates the bounds of its block and cell. The caller must store
// the surfel by SurfelBlock::Write().
std::int32_t SurfelMap::Place(const Surfel& surfel) {
  const std::int32_t i = CellAt(surfel.position_in_world);
  SurfelCell& cell = cells_[i];
  if (cell.blocks.empty() || block(cell.blocks.back()).count == SurfelBlock::kCapacity) {
    AddBlock(i);
  }
  SurfelBlock& last = block(cell.blocks.back());
  const int k = last.count++;
  last.Announce(k, surfel);
  cell.bounds.Add(last.bounds);
  ++size_;
  return cell.blocks.back() * SurfelBlock::kCapacity + k;
}

std::int32_t SurfelMap::Append(const Surfel& surfel) {
  const std::int32_t id = Place(surfel);
  block(BlockOf(id)).Write(PlaceOf(id), surfel);
  return id;
}

void SurfelMap::Append(const std::vector<Surfel>& surfels) {
  std::vector<std::int32_t> ids;
  ids.reserve(surfels.size());
  const auto write = [&](int begin, int end) {
    for (int i = begin; i < end; ++i) block(BlockOf(ids[i])).Write(PlaceOf(ids[i]), surfels[i]);
  };
  try {
    for (const Surfel& surfel : surfels) ids.push_back(Place(surfel));
  } catch (...) {  // out of memory: stores the surfels that have an id
    write(0, static_cast<int>(ids.size()));
    throw;
  }
  constexpr int kGrain = 512;
  ParallelFor(0, static_cast<int>(ids.size()), kGrain, write);
}

void SurfelMap::Merge(std::int32_t id, const SurfelObservation& observation, float max_confidence) {
  SurfelBlock& changed = block(BlockOf(id));
  changed.Merge(PlaceOf(id), observation, max_confidence);
  changed.bounds.Add((*this)[id].position_in_world);
  cells_[changed.cell].bounds.Add(changed.bounds);
}

void SurfelMap::Mark(std::int32_t id) {
  ThrowIf(id < 0 || id >= id_end() || !Has(id), "the map has no surfel with the id ", id);
  SurfelBlock& marked = block(BlockOf(id));
  marked.to_remove |= std::uint64_t{1} << PlaceOf(id);
  cells_[marked.cell].is_marked = true;
}

std::size_t SurfelMap::RemoveMarked() {
  const std::size_t before = size_;
  for (SurfelCell& cell : cells_) {
    if (!cell.is_marked) continue;
    RemoveMarked(&cell);
    cell.is_marked = false;
    if (cell.blocks.empty()) cell.bounds = {};
  }
  return before - size_;
}

std::size_t SurfelMap::Relocate(const std::vector<SurfelMove>& moves) {
  std::size_t moved = 0;
  for (const auto& [id, position] : moves) {
    if ((block(BlockOf(id)).to_remove >> PlaceOf(id) & 1) != 0) continue;
    Surfel surfel = (*this)[id];
    surfel.position_in_world = position;
    const std::int32_t place = Place(surfel);
    block(BlockOf(place)).Take(PlaceOf(place), block(BlockOf(id)), PlaceOf(id), position);
    Mark(id);
    ++moved;
  }
  RemoveMarked();
  return moved;
}

// The last unmarked surfel of the cell fills each gap.
void SurfelMap::RemoveMarked(SurfelCell* cell) {
  for (std::size_t b = 0; b < cell->blocks.size(); ++b) {
    SurfelBlock& hole = block(cell->blocks[b]);
    while (hole.to_remove != 0) {
      const SurfelBlock& last = block(cell->blocks.back());
      if ((last.to_remove >> (last.count - 1) & 1) == 0) {
        const int from = last.count - 1;
        hole.Take(__builtin_ctzll(hole.to_remove), last, from, last.Position(from));
        hole.to_remove &= hole.to_remove - 1;
      }
      RemoveLast(cell);
    }
  }
}

void SurfelMap::RemoveLast(SurfelCell* cell) {
  SurfelBlock& last = block(cell->blocks.back());
  --last.count;
  last.to_remove &= ~(std::uint64_t{1} << last.count);
  --size_;
  if (last.count > 0) return;
  free_blocks_.push_back(cell->blocks.back());
  cell->blocks.pop_back();
}

}  // namespace surfit
