#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <unordered_map>
#include <vector>

#include "surfit/mapping/surfel_block.h"

namespace surfit {

// Surfels of a cube of the grid. Merging can move surfels slightly out of the cube. Only the last
// block can be partly empty.
struct SurfelCell {
  std::vector<std::int32_t> blocks;
  SurfelBounds bounds;     // bounds of all blocks
  bool is_marked = false;  // contains marked surfels, see SurfelMap::RemoveMarked()
  std::uint64_t key = 0;   // identifies the cube
};

// New position of a surfel.
struct SurfelMove {
  std::int32_t id;
  Eigen::Vector3f position_in_world;  // m
};

// Map of surfels in the world frame, m. Surfels are stored in blocks, and blocks in the cells of a
// grid, so operations on a view access nearby cells only. Blocks keep their address when the map
// grows. Not thread-safe for changes; concurrent reads are safe.
//
// An id is block * SurfelBlock::kCapacity + place. It is valid until a surfel of the same cell is
// removed or changes its cell. Ids are below id_end(), with gaps (see Has()). Ids are not checked.
// Positions must be finite. They are stored in steps of 2^-16 m, and clamped beyond kFarthest_m.
class SurfelMap {
 public:
  static constexpr float kCellSize = 0.5f;        // m
  static constexpr float kFarthest_m = 524288.f;  // from the origin, along each axis

  std::size_t size() const { return size_; }
  std::int32_t id_end() const {
    return static_cast<std::int32_t>(blocks_.size()) * SurfelBlock::kCapacity;
  }
  bool Has(std::int32_t id) const { return PlaceOf(id) < block(BlockOf(id)).count; }
  // All ids in use, cell by cell. The order depends only on the sequence of changes.
  std::vector<std::int32_t> Ids() const;

  Surfel operator[](std::int32_t id) const { return block(BlockOf(id))[PlaceOf(id)]; }
  Rgb8 Color(std::int32_t id) const { return block(BlockOf(id)).Color(PlaceOf(id)); }

  // Returns the id of the new surfel. The colour must be in [0, 255] and all numbers finite, which
  // is not checked.
  std::int32_t Append(const Surfel& surfel);
  // Appends surfels in their order. If memory runs out, throws std::bad_alloc and keeps the surfels
  // appended before.
  void Append(const std::vector<Surfel>& surfels);

  // Like SurfelBlock::Merge(). Also updates the bounds, but not last_seen.
  void Merge(std::int32_t id, const SurfelObservation& observation, float max_confidence);

  // Marks a surfel for RemoveMarked(). Throws if the id is not in use.
  void Mark(std::int32_t id);
  // Removes all marked surfels, and returns their number. Ids in the affected cells change.
  std::size_t RemoveMarked();

  // Moves surfels to new positions, and to the cells of these positions. Removes all marked
  // surfels. Returns the number of moved surfels, without the marked ones. Ids in the affected
  // cells change.
  std::size_t Relocate(const std::vector<SurfelMove>& moves);

  // Direct access to cells and blocks. References to cells are valid until the next Append() or
  // Relocate(). The caller must keep masks and bounds consistent.
  std::int32_t cell_count() const { return static_cast<std::int32_t>(cells_.size()); }
  SurfelCell& cell(std::int32_t i) { return cells_[i]; }
  const SurfelCell& cell(std::int32_t i) const { return cells_[i]; }
  // Grid coordinates of a cell. The cube (0, 0, 0) has its centre at the world origin.
  static Eigen::Vector3i CubeOf(const SurfelCell& cell);
  SurfelBlock& block(std::int32_t i) { return blocks_[i]; }
  const SurfelBlock& block(std::int32_t i) const { return blocks_[i]; }

 private:
  static std::int32_t BlockOf(std::int32_t id) { return id / SurfelBlock::kCapacity; }
  static int PlaceOf(std::int32_t id) { return id % SurfelBlock::kCapacity; }
  std::int32_t CellAt(const Eigen::Vector3f& position_in_world);
  std::int32_t Place(const Surfel& surfel);
  void AddBlock(std::int32_t cell);
  void RemoveMarked(SurfelCell* cell);
  void RemoveLast(SurfelCell* cell);

  std::size_t size_ = 0;
  std::deque<SurfelBlock> blocks_;  // deque: blocks keep their address
  std::vector<std::int32_t> free_blocks_;
  std::vector<SurfelCell> cells_;
  std::unordered_map<std::uint64_t, std::int32_t> cell_of_key_;
};

}  // namespace surfit
