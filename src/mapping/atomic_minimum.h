#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "surfit/core/parallel.h"

namespace surfit {

// Minima over (value, index) pairs that many threads lower at once. A minimum does not depend on
// the order of its candidates, so the outcome is the same at any number of threads.

constexpr std::uint64_t kNoMinimum = ~std::uint64_t{0};

// Orders by value (>= 0), then by index. The highest bit is free for the caller.
inline std::uint64_t MinimumKey(float value, std::int32_t index) {
  std::uint32_t bits;  // of a float >= 0: they grow with it
  std::memcpy(&bits, &value, sizeof(bits));
  return std::uint64_t{bits} << 32 | static_cast<std::uint32_t>(index);
}

inline std::int32_t IndexOfKey(std::uint64_t key) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(key));
}

// Of a key whose highest bit is clear.
inline float ValueOfKey(std::uint64_t key) {
  const std::uint32_t bits = static_cast<std::uint32_t>(key >> 32);
  float value;
  std::memcpy(&value, &bits, sizeof(value));
  return value;
}

inline void LowerTo(std::uint64_t key, std::atomic<std::uint64_t>* minimum) {
  std::uint64_t present = minimum->load(std::memory_order_relaxed);
  while (key < present &&
         !minimum->compare_exchange_weak(present, key, std::memory_order_relaxed)) {
  }
}

// Makes `count` minima without any candidate yet.
inline void ResetMinima(std::size_t count, std::vector<std::atomic<std::uint64_t>>* minima) {
  if (minima->size() != count) *minima = std::vector<std::atomic<std::uint64_t>>(count);
  ParallelFor(0, static_cast<int>(count), 1 << 15, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) (*minima)[i].store(kNoMinimum, std::memory_order_relaxed);
  });
}

}  // namespace surfit
