#pragma once

#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "surfit/core/image.h"
#include "surfit/core/parallel.h"

namespace surfit {

// Data of all points of one functor type (point_functor.h), as a structure of arrays with elements
// S. Array i has the value data[i] of each point. Fewer than 2^31 points.
template <typename Functor, typename S>
class BatchData {
 public:
  using Arrays = std::array<RawVector<S>, Functor::kDataSize>;

  BatchData() = default;
  // All arrays must have the same size, which is not checked.
  explicit BatchData(Arrays arrays) : arrays_(std::move(arrays)) {}

  // Copies the data of functors, one point per functor.
  static BatchData FromFunctors(const std::vector<Functor>& functors) {
    constexpr int kGrain = 4096;
    Arrays arrays;
    for (auto& array : arrays) array.resize(functors.size());
    ParallelFor(0, static_cast<int>(functors.size()), kGrain, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) {
        for (int k = 0; k < Functor::kDataSize; ++k) {
          arrays[k][i] = static_cast<S>(functors[i].data[k]);
        }
      }
    });
    return BatchData(std::move(arrays));
  }

  std::size_t size() const { return arrays_[0].size(); }
  const S* array(int i) const { return arrays_[i].data(); }

 private:
  Arrays arrays_;
};

}  // namespace surfit
