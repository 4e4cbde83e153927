#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <unordered_map>
#include <vector>

#include "surfit/mapping/surfel_block.h"

namespace surfit {

// The surfels of one cube of space, but for the little way that merging has moved some since: all
// blocks but the last are full.
struct SurfelCell {
  std::vector<std::int32_t> blocks;
  SurfelBounds bounds;     // of all of them
  bool is_marked = false;  // some of the surfels are: see SurfelMap::RemoveMarked()
  std::uint64_t key = 0;   // of its cube, among the map's cells
};

// The fused map: surfels in blocks, blocks in the cells of a grid, so that work on what a camera
// sees touches little else, and growing moves nothing.
//
// An id names a surfel until one is removed from its cell: block * SurfelBlock::kCapacity + place.
// Ids are below id_end(), but not all of these are in use.
class SurfelMap {
 public:
  static constexpr float kCellSize = 0.5f;  // metres

  std::size_t size() const { return size_; }
  std::int32_t id_end() const {
    return static_cast<std::int32_t>(blocks_.size()) * SurfelBlock::kCapacity;
  }
  bool Has(std::int32_t id) const { return PlaceOf(id) < block(BlockOf(id)).count; }
  // All ids, cell by cell. The same changes to a map give the same order.
  std::vector<std::int32_t> Ids() const;

  Surfel operator[](std::int32_t id) const { return block(BlockOf(id))[PlaceOf(id)]; }
  Rgb8 Color(std::int32_t id) const { return block(BlockOf(id)).Color(PlaceOf(id)); }

  // Returns its id.
  std::int32_t Append(const Surfel& surfel);
  // Appends them in their order, written in parallel.
  void Append(const std::vector<Surfel>& surfels);

  // SurfelBlock::Merge, and keeps the bounds.
  void Merge(std::int32_t id, const SurfelObservation& observation, float max_confidence);

  // Marks a surfel for RemoveMarked().
  void Mark(std::int32_t id);
  // Removes all marked surfels; the last ones of a cell take their places. Returns how many there
  // were.
  std::size_t RemoveMarked();

  // Takes surfels that lie in the cubes of other cells to these, after their positions have been
  // changed. Returns how many there were.
  std::size_t Rehome();

  // For those who work on many surfels at once. Who changes them keeps true what blocks and cells
  // tell about them.
  std::int32_t cell_count() const { return static_cast<std::int32_t>(cells_.size()); }
  SurfelCell& cell(std::int32_t i) { return cells_[i]; }
  const SurfelCell& cell(std::int32_t i) const { return cells_[i]; }
  // A cell's cube, counted along each axis from the one that is centred at the world's origin.
  static Eigen::Vector3i CubeOf(const SurfelCell& cell);
  SurfelBlock& block(std::int32_t i) { return blocks_[i]; }
  const SurfelBlock& block(std::int32_t i) const { return blocks_[i]; }

 private:
  static std::int32_t BlockOf(std::int32_t id) { return id / SurfelBlock::kCapacity; }
  static int PlaceOf(std::int32_t id) { return id % SurfelBlock::kCapacity; }
  std::int32_t CellAt(const Eigen::Vector3f& position_in_world);
  std::int32_t Place(const Surfel& surfel);
  void AddBlock(std::int32_t cell);
  std::vector<std::int32_t> Strays() const;
  void RemoveMarked(SurfelCell* cell);
  void RemoveLast(SurfelCell* cell);

  std::size_t size_ = 0;
  std::deque<SurfelBlock> blocks_;  // never moved
  std::vector<std::int32_t> free_blocks_;
  std::vector<SurfelCell> cells_;
  std::unordered_map<std::uint64_t, std::int32_t> cell_of_key_;
};

}  // namespace surfit
