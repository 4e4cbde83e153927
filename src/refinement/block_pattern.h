#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "refinement/shared_surfels.h"

namespace surfit {

// Which pairs of poses the reduced system ties: those that share a surfel, and each pose with
// itself and the next one (MotionPrior). Others have no block.
class BlockPattern {
 public:
  static constexpr std::int32_t kNoBlock = -1;

  BlockPattern(const SharedSurfels& shared, std::size_t pose_count);

  int pose_count() const { return pose_count_; }
  std::size_t block_count() const { return block_count_; }

  // The index of the block of two poses, row >= column, or kNoBlock. Blocks are numbered row by
  // row. The table takes 4 bytes for each pair, 1 / 72 of what its block would.
  std::int32_t IndexOf(int row, int column) const { return indices_[PairOf(row, column)]; }

 private:
  static std::size_t PairOf(int row, int column) {
    return static_cast<std::size_t>(row) * (row + 1) / 2 + column;
  }

  int pose_count_;
  std::size_t block_count_ = 0;
  std::vector<std::int32_t> indices_;  // of the lower triangle, row by row
};

}  // namespace surfit
