#pragma once

#include <array>
#include <cstdint>

namespace surfit {

// How a surface cuts a cell (Nielson 2004, dual marching cubes). Corner c of a cell is at (c & 1,
// c >> 1 & 1, c >> 2); a pattern has bit c set where corner c is behind the surface. The surface
// cuts the edges between corners of different sides, and passes each face from edge to edge; where
// two ways are open it keeps the corners that are behind apart. So cut edges form cycles, and the
// surface has a patch, and the mesh a vertex, for each of these.
struct CellPatches {
  static constexpr int kEdges = 12, kCorners = 8;
  static constexpr std::uint8_t kNone = 0xff;  // an edge that is not cut

  std::uint8_t count = 0;
  std::array<std::uint8_t, kEdges> of_edge = {};  // which patch cuts it
};

// Edge 4 a + k is along axis a and begins in EdgeCorner(a, k): k counts the other two axes, a + 1
// first.
constexpr int EdgeCorner(int axis, int k) {
  return (k & 1) << (axis + 1) % 3 | (k >> 1) << (axis + 2) % 3;
}

// Of all 256 patterns.
const std::array<CellPatches, 256>& AllCellPatches();

}  // namespace surfit
