#include "refinement/block_pattern.h"

namespace surfit {

BlockPattern::BlockPattern(const SharedSurfels& shared, std::size_t pose_count)
    : pose_count_(static_cast<int>(pose_count)),
      indices_(pose_count * (pose_count + 1) / 2, kNoBlock) {
  constexpr std::int32_t kTied = 0;
  for (int k = 0; k < pose_count_; ++k) {
    indices_[PairOf(k, k)] = kTied;
    if (k > 0) indices_[PairOf(k, k - 1)] = kTied;
  }
  for (const SharedSurfel& surfel : shared.surfels) {
    for (std::size_t i = surfel.begin; i < surfel.end; ++i) {
      for (std::size_t j = surfel.begin; j < i; ++j) {
        indices_[PairOf(shared.observations[i].keyframe, shared.observations[j].keyframe)] = kTied;
      }
    }
  }
  for (std::int32_t& index : indices_) {
    if (index == kTied) index = static_cast<std::int32_t>(block_count_++);
  }
}

}  // namespace surfit
