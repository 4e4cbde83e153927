#pragma once

#include <cstdint>

#include "surfit/core/image.h"

namespace surfit::testing {

inline constexpr int kSlantedWidth = 80, kSlantedHeight = 60;

// Depth of a slanted wall and a box in front of it, in mm. It moves with the frame.
inline Image<std::uint16_t> SlantedDepth(int frame) {
  Image<std::uint16_t> depth(kSlantedWidth, kSlantedHeight);
  for (int v = 0; v < kSlantedHeight; ++v) {
    for (int u = 0; u < kSlantedWidth; ++u) {
      const bool is_box = u > 20 + frame && u < 40 + frame && v > 20 && v < 40;
      depth(u, v) = static_cast<std::uint16_t>((is_box ? 900 : 1500) + 9 * u + 13 * v + 11 * frame);
    }
  }
  return depth;
}

template <typename F>
Image<std::uint16_t> Changed(Image<std::uint16_t> depth, const F& change) {
  for (auto& count : depth) count = static_cast<std::uint16_t>(change(count));
  return depth;
}

}  // namespace surfit::testing
