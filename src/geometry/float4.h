#pragma once

#include <cstdint>
#include <cstring>
#ifdef __SSE2__
#include <emmintrin.h>
#endif

namespace surfit {

// Vectors of four numbers: extensions of GCC and Clang for all processors. A comparison gives -1
// (true) or 0 per lane. `mask ? a : b` selects lanes from a or b.
using Float4 = float __attribute__((vector_size(16)));
using Int4 = std::int32_t __attribute__((vector_size(16)));

inline Float4 AllLanes(float x) { return Float4{} + x; }

// Reads four values, without alignment.
inline Float4 Load4(const float* from) {
  Float4 result;
  std::memcpy(&result, from, sizeof(result));
  return result;
}
inline void Store4(Float4 values, float* to) { std::memcpy(to, &values, sizeof(values)); }

// Per lane. NaN if a is NaN, and a if b is NaN.
inline Float4 Max(Float4 a, Float4 b) { return a < b ? b : a; }

// Bit k of the result is set if lane k of the mask is true.
inline unsigned Bits(Int4 mask) {
#ifdef __SSE2__
  return static_cast<unsigned>(_mm_movemask_ps(reinterpret_cast<__m128>(mask)));
#else
  return (mask[0] & 1u) | (mask[1] & 2u) | (mask[2] & 4u) | (mask[3] & 8u);
#endif
}

}  // namespace surfit
