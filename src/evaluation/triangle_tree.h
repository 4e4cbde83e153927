#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

namespace surfit {

// Bounding volume hierarchy of triangles. Queries are exact in double precision and thread-safe.
class TriangleTree {
 public:
  // `triangles`: indices of `vertices`, three per triangle. Triangles with a vertex that is not
  // finite are ignored. Throws InputError if no triangle remains, or if an index is invalid.
  TriangleTree(const std::vector<Eigen::Vector3f>& vertices,
               const std::vector<Eigen::Vector3i>& triangles);

  std::size_t size() const { return triangles_.size(); }

  // Distance from a point to the nearest triangle, m.
  double Distance(const Eigen::Vector3d& point) const;

  // Points on the triangles, with equal area per point. `spacing_m`: square root of this area. The
  // spacing is larger if there would be more than `max_points`. Deterministic. Throws InputError if
  // the total area is 0.
  std::vector<Eigen::Vector3f> Sample(double spacing_m, std::size_t max_points) const;

 private:
  struct Triangle {
    Eigen::Vector3d a, b, c;
  };
  struct Node {
    Eigen::AlignedBox3d box;
    std::uint32_t first = 0, last = 0;  // triangles of a leaf
    std::uint32_t right = 0;            // index of the second child; 0: leaf
  };

  static double SquaredDistance(const Triangle& triangle, const Eigen::Vector3d& point);
  std::uint32_t Build(std::uint32_t first, std::uint32_t last);
  void Search(std::uint32_t node, const Eigen::Vector3d& point, double* least) const;

  std::vector<Triangle> triangles_;
  std::vector<Node> nodes_;  // the first child follows its parent
};

}  // namespace surfit
