#include "surfit/registration/association.h"

#include <cstring>
#include <vector>

#include "surfit/core/parallel.h"

namespace surfit {

// Each block is found where there is room for it in any case; then they close up, array by array.
PairBuffer Association::Collect(const Rigid3d& target_from_source) const {
  constexpr int kGrain = 8;
  const auto finder = At(target_from_source);
  const int blocks = block_count(), capacity = block_capacity();
  PairBuffer pairs;
  pairs.SetCapacity(blocks * capacity);
  std::vector<int> sizes(blocks);
  ParallelFor(0, blocks, kGrain, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) sizes[i] = finder->Find(i, i * capacity, &pairs);
  });
  const auto arrays = pairs.Arrays();
  ParallelFor(0, PairBuffer::kArrays, 1, [&](int k, int) {
    float* const values = arrays[k]->data();
    float* to = values;
    for (int i = 0; i < blocks; ++i) {
      std::memmove(to, values + i * capacity, sizes[i] * sizeof(float));
      to += sizes[i];
    }
  });
  for (const int size : sizes) pairs.size += size;
  return pairs;
}

Correspondences Moved(Correspondences pairs, const Rigid3d& motion) {
  for (int i = 0; i < pairs.size; ++i) {
    const Eigen::Vector3d p = motion * pairs.p(i), m = motion.rotation * pairs.m(i);
    pairs.px[i] = p.x(), pairs.py[i] = p.y(), pairs.pz[i] = p.z();
    pairs.mx[i] = m.x(), pairs.my[i] = m.y(), pairs.mz[i] = m.z();
  }
  return pairs;
}

}  // namespace surfit
