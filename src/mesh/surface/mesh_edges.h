#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "surfit/mesh/triangle_mesh.h"

namespace surfit {

// Neighbour of each triangle at each side; kNone: none or several. Side k is the edge from corner k
// to the next corner.
class TriangleNeighbors {
 public:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  // Does not keep a reference.
  explicit TriangleNeighbors(const std::vector<TriangleMesh::Triangle>& triangles);

  // Indices of the neighbours at the sides 0, 1 and 2.
  const std::array<std::uint32_t, 3>& Of(std::uint32_t triangle) const { return beyond_[triangle]; }

 private:
  std::vector<std::array<std::uint32_t, 3>> beyond_;
};

}  // namespace surfit
