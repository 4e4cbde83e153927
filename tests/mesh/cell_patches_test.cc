#include "mesh/surface/cell_patches.h"

#include <gtest/gtest.h>

#include <array>
#include <set>

namespace surfit::testing {
namespace {

bool IsCut(int pattern, int edge) {
  const int axis = edge / 4, from = EdgeCorner(axis, edge % 4), to = from | 1 << axis;
  return (pattern >> from & 1) != (pattern >> to & 1);
}

TEST(CellPatches, OnlyCutEdgesHavePatches) {
  for (int pattern = 0; pattern < 256; ++pattern) {
    const CellPatches& patches = AllCellPatches()[pattern];
    std::array<int, 4> edges = {};
    for (int e = 0; e < CellPatches::kEdges; ++e) {
      ASSERT_EQ(patches.of_edge[e] != CellPatches::kNone, IsCut(pattern, e)) << pattern;
      if (!IsCut(pattern, e)) continue;
      ASSERT_LT(patches.of_edge[e], patches.count) << pattern;
      ++edges[patches.of_edge[e]];
    }
    for (int p = 0; p < patches.count; ++p) EXPECT_GE(edges[p], 3) << pattern;
  }
}

// There is one patch per group of corners behind the surface that are connected by edges. Corners
// that share only a face diagonal are in separate groups. There are fewer patches if the corners in
// front form two groups.
TEST(CellPatches, SeparatesCornersConnectedByDiagonalOnly) {
  EXPECT_EQ(AllCellPatches()[0].count, 0);
  EXPECT_EQ(AllCellPatches()[255].count, 0);
  EXPECT_EQ(AllCellPatches()[0b00000001].count, 1);
  EXPECT_EQ(AllCellPatches()[0b00001111].count, 1);  // a plane
  EXPECT_EQ(AllCellPatches()[0b00001001].count, 2);  // across a face
  EXPECT_EQ(AllCellPatches()[0b10000001].count, 2);  // across the cell
  EXPECT_EQ(AllCellPatches()[0b01101001].count, 4);  // every other corner
  EXPECT_EQ(AllCellPatches()[0b11110110].count, 1);  // complement of 0b00001001: connected
}

}  // namespace
}  // namespace surfit::testing
