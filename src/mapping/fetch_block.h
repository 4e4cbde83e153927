#pragma once

#include <cstddef>

#include "surfit/mapping/surfel_block.h"

namespace surfit {

// Asks for the memory [begin, end) that is soon to be looked at.
inline void Fetch(const void* begin, const void* end) {
  constexpr std::ptrdiff_t kLine = 64;
  for (auto* line = static_cast<const char*>(begin); line < end; line += kLine) {
    __builtin_prefetch(line);
  }
}

// Ask for parts of a block that is soon to be looked at. Blocks are anywhere in memory, and too
// short for the processor to see what comes next.
inline void FetchShapes(const SurfelBlock& block) { Fetch(&block, block.first_seen); }
inline void FetchAll(const SurfelBlock& block) { Fetch(&block, &block + 1); }
inline void FetchAges(const SurfelBlock& block) {
  Fetch(&block, &block.bounds + 1);
  Fetch(block.confidence, block.first_seen);
  Fetch(block.last_seen, block.red);
}

}  // namespace surfit
