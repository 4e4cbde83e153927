#pragma once

#include <cstdint>

#include "mapping/map/block_lanes.h"
#include "surfit/mapping/surfel_block.h"

namespace surfit {

// What a frame has seen of the surfels of a block, to be merged with all of them at once.
class BlockSightings {
 public:
  // Nothing is seen of the block yet.
  void Clear();
  // Of the surfel at a place, which nothing was seen of yet. Its weight is positive.
  void Add(int place, const SurfelObservation& seen);
  bool empty() const { return mask_ == 0; }

  // SurfelBlock::Merge() of each surfel that was seen, with the same outcome bit for bit.
  void MergeInto(SurfelBlock* block, float max_confidence) const;

 private:
  void MergeShapes(SurfelBlock* block) const;
  void MergeColors(SurfelBlock* block) const;

  std::uint64_t mask_ = 0, within_mask_ = 0;  // of those seen, and those not seen at an edge alone
  // As in SurfelObservation; where nothing is seen the weights are 0, the others anything.
  alignas(32) PerSurfel<float> weight_ = {}, shape_weight_ = {}, color_weight_ = {};
  alignas(32) PerSurfel<float> x_ = {}, y_ = {}, z_ = {}, nx_ = {}, ny_ = {}, nz_ = {};
  alignas(32) PerSurfel<float> radius_m_ = {};
  alignas(32) PerSurfel<float> red_ = {}, green_ = {}, blue_ = {};
};

}  // namespace surfit
