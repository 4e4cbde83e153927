#include "surfit/registration/association.h"

#include <algorithm>
#include <vector>

#include "surfit/core/parallel.h"

namespace surfit {

PairBuffer Association::Collect(const Rigid3d& target_from_source) const {
  constexpr int kGrain = 8;
  const auto finder = At(target_from_source);
  std::vector<PairBuffer> blocks(block_count());
  ParallelFor(0, block_count(), kGrain, [&](int begin, int end) {
    for (int block = begin; block < end; ++block) {
      blocks[block].SetCapacity(block_capacity());
      finder->Find(block, &blocks[block]);
    }
  });
  std::vector<int> first = {0};
  for (const PairBuffer& block : blocks) first.push_back(first.back() + block.size);
  PairBuffer all;
  all.size = first.back();
  const auto to = all.Arrays();
  ParallelFor(0, PairBuffer::kArrays, 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) to[i]->resize(all.size);
  });
  ParallelFor(0, block_count(), kGrain, [&](int begin, int end) {
    for (int block = begin; block < end; ++block) {
      const auto from = blocks[block].Arrays();
      for (int i = 0; i < PairBuffer::kArrays; ++i) {
        std::copy_n(from[i]->begin(), blocks[block].size, to[i]->begin() + first[block]);
      }
    }
  });
  return all;
}

}  // namespace surfit
