#pragma once

#include <array>
#include <cstdint>

namespace surfit {

// Surface patches in a grid cell (Nielson 2004, dual marching cubes). Corner c of a cell is at (c &
// 1, c >> 1 & 1, c >> 2). Bit c of a pattern is set if corner c is behind the surface.
//
// The surface cuts edges between corners on different sides. In each face, it connects the cut
// edges; an ambiguous face separates the corners behind the surface.
struct CellPatches {
  static constexpr int kEdges = 12, kCorners = 8;
  static constexpr std::uint8_t kNone = 0xff;  // edge without cut

  std::uint8_t count = 0;  // number of patches
  // Patch of each edge, from 0 to count - 1, or kNone.
  std::array<std::uint8_t, kEdges> of_edge = {};
};

// Edge 4 a + k is parallel to axis a and begins at EdgeCorner(a, k). The bits of k are the
// coordinates along the axes a + 1 and a + 2.
constexpr int EdgeCorner(int axis, int k) {
  return (k & 1) << (axis + 1) % 3 | (k >> 1) << (axis + 2) % 3;
}

// Patches of all patterns. Computed at the first call, which is thread-safe.
const std::array<CellPatches, 256>& AllCellPatches();

}  // namespace surfit
