#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "surfit/core/lanes.h"
#include "surfit/mapping/surfel_block.h"

namespace surfit {

// One value per surfel of a block.
template <typename T>
using PerSurfel = T[SurfelBlock::kCapacity];

// Masks have bit k for surfel k of a block. Flags must be 0 or 1.
inline std::uint64_t MaskOf(const PerSurfel<std::uint8_t>& flags) {
  std::uint64_t mask = 0;
  for (int byte = 0; byte < 8; ++byte) {
    std::uint64_t eight;
    std::memcpy(&eight, &flags[8 * byte], 8);
    // moves bit 0 of byte k to bit k of the highest byte
    mask |= (eight * 0x0102040810204080u) >> 56 << (8 * byte);
  }
  return mask;
}

// The block must not be empty.
inline std::uint64_t MaskOfAll(const SurfelBlock& block) {
  return ~std::uint64_t{0} >> (SurfelBlock::kCapacity - block.count);
}

// Mask of the surfels last seen in `frame` or later. It can have bits of unused places.
inline std::uint64_t MaskOfActive(const SurfelBlock& block, int frame) {
  if (block.bounds.least_last_seen >= frame) return ~std::uint64_t{0};
  PerSurfel<std::uint8_t> seen;
  for (int k = 0; k < SurfelBlock::kCapacity; ++k) seen[k] = block.LastSeen(k) >= frame;
  return MaskOf(seen);
}

// Calls f(k) for each set bit k, in ascending order.
template <typename F>
void ForEachBit(std::uint64_t mask, const F& f) {
  for (; mask != 0; mask &= mask - 1) f(__builtin_ctzll(mask));
}

inline float LeastOf(const PerSurfel<float>& numbers) {
  float least[8];
  for (int j = 0; j < 8; ++j) least[j] = numbers[j];
  for (int k = 8; k < SurfelBlock::kCapacity; k += 8) {
    for (int j = 0; j < 8; ++j) least[j] = numbers[k + j] < least[j] ? numbers[k + j] : least[j];
  }
  for (int j = 1; j < 8; ++j) least[0] = least[j] < least[0] ? least[j] : least[0];
  return least[0];
}

// The block must not be empty.
inline void BoundPositions(SurfelBlock* block) {
  WithInstructions([&](auto) {
    const PerSurfel<std::uint16_t>* const positions[] = {&block->x, &block->y, &block->z};
    for (int axis = 0; axis < 3; ++axis) {
      const PerSurfel<std::uint16_t>& all = *positions[axis];
      std::uint16_t low = all[0], high = all[0];
      for (int k = 0; k < SurfelBlock::kCapacity; ++k) {
        const std::uint16_t used = k < block->count ? all[k] : all[0];
        low = used < low ? used : low;
        high = used > high ? used : high;
      }
      block->bounds.low[axis] = block->origin[axis] + SmallCoordinate::ToFloat(low);
      block->bounds.high[axis] = block->origin[axis] + SmallCoordinate::ToFloat(high);
    }
  });
}

// Prefetches the memory in [begin, end).
inline void Fetch(const void* begin, const void* end) {
  constexpr std::ptrdiff_t kLine = 64;
  for (auto* line = static_cast<const char*>(begin); line < end; line += kLine) {
    __builtin_prefetch(line);
  }
}

// Prefetch parts of a block.
inline void FetchShapes(const SurfelBlock& block) { Fetch(&block, block.first_seen_low); }
inline void FetchAll(const SurfelBlock& block) { Fetch(&block, &block + 1); }
inline void FetchAges(const SurfelBlock& block) {
  Fetch(&block, &block.bounds + 1);
  Fetch(block.confidence, block.first_seen_low);
}

}  // namespace surfit
