#pragma once

#include <cstdint>

#include "mapping/map/block_lanes.h"
#include "surfit/mapping/surfel_block.h"

namespace surfit {

// Observations of the surfels of a block in one frame, for vectorised merging.
class BlockObservations {
 public:
  void Clear();
  // Adds the observation of the surfel at `place`. Requires a positive weight and no earlier
  // observation of this surfel.
  void Add(int place, const SurfelObservation& seen);
  bool empty() const { return mask_ == 0; }

  // Merges all observations. The result is bitwise identical to SurfelBlock::Merge() for each
  // surfel.
  void MergeInto(SurfelBlock* block, float max_confidence) const;

 private:
  void MergeShapes(SurfelBlock* block) const;
  void MergeColors(SurfelBlock* block) const;

  // Surfels with an observation, and surfels that are not only observed at edges.
  std::uint64_t mask_ = 0, within_mask_ = 0;
  // Members of SurfelObservation. Weights are 0 for surfels without observation, and other values
  // are unspecified.
  alignas(32) PerSurfel<float> weight_ = {}, shape_weight_ = {}, color_weight_ = {};
  alignas(32) PerSurfel<float> x_ = {}, y_ = {}, z_ = {}, nx_ = {}, ny_ = {}, nz_ = {};
  alignas(32) PerSurfel<float> radius_m_ = {};
  alignas(32) PerSurfel<float> red_ = {}, green_ = {}, blue_ = {};
};

}  // namespace surfit
