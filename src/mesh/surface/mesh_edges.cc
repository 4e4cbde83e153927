#include "mesh/surface/mesh_edges.h"

#include <algorithm>
#include <tuple>

namespace surfit {
namespace {

struct Side {
  std::uint64_t edge;
  std::uint32_t triangle;
  std::uint32_t k;
};

}  // namespace

TriangleNeighbors::TriangleNeighbors(const std::vector<TriangleMesh::Triangle>& triangles)
    : beyond_(triangles.size(), {kNone, kNone, kNone}) {
  std::vector<Side> sides;
  sides.reserve(3 * triangles.size());
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(triangles[i][k], triangles[i][(k + 1) % 3]);
      sides.push_back({std::uint64_t{low} << 32 | high, i, k});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::tie(a.edge, a.triangle, a.k) < std::tie(b.edge, b.triangle, b.k);
  });
  for (std::size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
    while (end < sides.size() && sides[end].edge == sides[begin].edge) ++end;
    if (end - begin != 2) continue;
    const Side &a = sides[begin], &b = sides[begin + 1];
    beyond_[a.triangle][a.k] = b.triangle;
    beyond_[b.triangle][b.k] = a.triangle;
  }
}

}  // namespace surfit
