#pragma once

#include "mapping/per_surfel.h"
#include "surfit/core/lanes.h"

namespace surfit {

// Finds the bounds of the positions once more, after merging.
inline void BoundPositions(SurfelBlock* block) {
  WithInstructions([&](auto) {
    const PerSurfel<float>* const positions[] = {&block->x, &block->y, &block->z};
    for (int axis = 0; axis < 3; ++axis) {
      const PerSurfel<float>& all = *positions[axis];
      PerSurfel<float> used, negative;
      for (int k = 0; k < SurfelBlock::kCapacity; ++k) {
        used[k] = k < block->count ? all[k] : all[0];
        negative[k] = -used[k];
      }
      block->bounds.low[axis] = LeastOf(used);
      block->bounds.high[axis] = -LeastOf(negative);
    }
  });
}

}  // namespace surfit
