#pragma once

#include <cstdint>
#include <cstring>
#ifdef __SSE2__
#include <emmintrin.h>
#endif

namespace surfit {

// Four numbers to compute with at once: vector types of GCC and Clang, on any processor.
// Comparisons are -1 or 0 in each lane; `mask ? a : b` takes each lane from a or b.
using Float4 = float __attribute__((vector_size(16)));
using Int4 = std::int32_t __attribute__((vector_size(16)));

constexpr Int4 kLanes = {0, 1, 2, 3};

inline Float4 AllLanes(float x) { return Float4{} + x; }
inline Int4 AllLanes(std::int32_t x) { return Int4{} + x; }

inline Float4 Load4(const float* from) {
  Float4 result;
  std::memcpy(&result, from, sizeof(result));
  return result;
}
inline Int4 Load4(const std::int32_t* from) {
  Int4 result;
  std::memcpy(&result, from, sizeof(result));
  return result;
}
inline void Store4(Float4 values, float* to) { std::memcpy(to, &values, sizeof(values)); }
inline void Store4(Int4 values, std::int32_t* to) { std::memcpy(to, &values, sizeof(values)); }

inline Float4 ToFloat(Int4 x) { return __builtin_convertvector(x, Float4); }

// Towards zero.
inline Int4 ToInt(Float4 x) { return __builtin_convertvector(x, Int4); }

// The largest integers not above x, for -1024 < x < 2^22: a conversion alone, unlike std::floor.
inline Int4 Floor(Float4 x) { return __builtin_convertvector(x + 1024.f, Int4) - 1024; }

inline Float4 Min(Float4 a, Float4 b) { return a < b ? a : b; }
inline Float4 Max(Float4 a, Float4 b) { return a < b ? b : a; }
inline Int4 Min(Int4 a, Int4 b) { return a < b ? a : b; }
inline Int4 Max(Int4 a, Int4 b) { return a < b ? b : a; }

// Whether the mask is set in any lane.
inline bool Any(Int4 mask) {
  std::uint64_t half[2];
  std::memcpy(half, &mask, sizeof(half));
  return (half[0] | half[1]) != 0;
}

// Bit k of the result is set where lane k of the mask is.
inline unsigned Bits(Int4 mask) {
#ifdef __SSE2__
  return static_cast<unsigned>(_mm_movemask_ps(reinterpret_cast<__m128>(mask)));
#else
  return (mask[0] & 1u) | (mask[1] & 2u) | (mask[2] & 4u) | (mask[3] & 8u);
#endif
}

}  // namespace surfit
