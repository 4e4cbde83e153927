#pragma once

#include <array>
#include <cstdint>

#include "surfit/core/lanes.h"
#if SURFIT_HAS_AVX2
#include <immintrin.h>
#endif

namespace surfit {

// Moves those of eight lanes that a mask selects to the front, in their order; what the others then
// hold is unspecified.
template <typename Instructions>
class LanePacking {
 public:
  using V = Lanes<float, Instructions>;

  explicit LanePacking(const typename V::Mask& mask) {
    for (int k = 0; k < V::kCount; ++k) {
      if (mask.v[k] != 0) lane_[count_++] = k;
    }
  }

  int count() const { return count_; }
  V operator()(const V& x) const {
    V packed;
    for (int k = 0; k < count_; ++k) packed.v[k] = x.v[lane_[k]];
    return packed;
  }

 private:
  int lane_[V::kCount];
  int count_ = 0;
};

#if SURFIT_HAS_AVX2
// For each set of eight bits: which are set, ascending.
inline constexpr auto kSetBits = [] {
  std::array<std::array<std::int32_t, 8>, 256> table{};
  for (int bits = 0; bits < 256; ++bits) {
    for (int k = 0, count = 0; k < 8; ++k) {
      if ((bits >> k & 1) != 0) table[bits][count++] = k;
    }
  }
  return table;
}();

template <>
class LanePacking<Avx2Instructions> {
 public:
  using V = Lanes<float, Avx2Instructions>;

  SURFIT_AVX2 explicit LanePacking(const V::Mask& mask) {
    const int bits = _mm256_movemask_ps(reinterpret_cast<__m256>(mask.v));
    count_ = __builtin_popcount(bits);
    std::memcpy(&lane_, kSetBits[bits].data(), sizeof(lane_));
  }

  int count() const { return count_; }
  SURFIT_AVX2 V operator()(const V& x) const {
    return V::Vector(_mm256_permutevar8x32_ps(__m256(x.v), lane_));
  }

 private:
  __m256i lane_;
  int count_;
};
#endif

}  // namespace surfit
