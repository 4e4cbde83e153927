#pragma once

#include <cstdint>

#include "mapping/map/block_lanes.h"
#include "surfit/mapping/surfel_block.h"

namespace surfit {

// Observations of a block in one frame, for vectorised merging. Call Clear() before reuse. Not
// thread-safe.
class BlockObservations {
 public:
  // Removes all observations.
  void Clear();
  // Adds an observation with positive weight. Each surfel can have one observation. `place`: index
  // in the block.
  void Add(int place, const SurfelObservation& seen);
  bool empty() const { return mask_ == 0; }

  // Merges all observations. Bitwise identical to SurfelBlock::Merge(). Does not change `last_seen`
  // and the bounds.
  void MergeInto(SurfelBlock* block, float max_confidence) const;

 private:
  void MergeShapes(SurfelBlock* block) const;
  void MergeColors(SurfelBlock* block) const;

  // Bit masks of surfels: with an observation, and with an observation that is not at a depth edge.
  std::uint64_t mask_ = 0, within_mask_ = 0;
  // Members of SurfelObservation. Without observation, weights are 0 and other values are
  // unspecified.
  alignas(32) PerSurfel<float> weight_ = {}, shape_weight_ = {}, color_weight_ = {};
  alignas(32) PerSurfel<float> x_ = {}, y_ = {}, z_ = {}, nx_ = {}, ny_ = {}, nz_ = {};
  alignas(32) PerSurfel<float> radius_m_ = {};
  alignas(32) PerSurfel<float> red_ = {}, green_ = {}, blue_ = {};
};

}  // namespace surfit
