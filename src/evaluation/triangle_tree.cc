#include "evaluation/triangle_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "surfit/core/error.h"

namespace surfit {
namespace {

constexpr std::uint32_t kMaxLeaf = 4;  // triangles

double SquaredDistanceToSegment(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                const Eigen::Vector3d& point) {
  const Eigen::Vector3d along = b - a, offset = point - a;
  const double squared_length = along.squaredNorm();
  const double share =
      squared_length > 0 ? std::clamp(along.dot(offset) / squared_length, 0., 1.) : 0;
  return (offset - share * along).squaredNorm();
}

}  // namespace

TriangleTree::TriangleTree(const std::vector<Eigen::Vector3f>& vertices,
                           const std::vector<Eigen::Vector3i>& triangles) {
  const auto count = static_cast<int>(vertices.size());
  for (const Eigen::Vector3i& t : triangles) {
    ThrowIf(t.minCoeff() < 0 || t.maxCoeff() >= count, "a triangle has the vertices ", t.x(), ", ",
            t.y(), " and ", t.z(), ", must be 0 to ", count - 1);
    const Triangle triangle = {vertices[t.x()].cast<double>(), vertices[t.y()].cast<double>(),
                               vertices[t.z()].cast<double>()};
    if (triangle.a.allFinite() && triangle.b.allFinite() && triangle.c.allFinite())
      triangles_.push_back(triangle);
  }
  ThrowIf(triangles_.empty(), "the mesh has no triangle with finite vertices");
  nodes_.reserve(2 * triangles_.size());
  Build(0, static_cast<std::uint32_t>(triangles_.size()));
}

std::uint32_t TriangleTree::Build(std::uint32_t first, std::uint32_t last) {
  const auto index = static_cast<std::uint32_t>(nodes_.size());
  Node node;
  Eigen::AlignedBox3d centers;  // tripled centroids
  for (std::uint32_t i = first; i < last; ++i) {
    const Triangle& t = triangles_[i];
    node.box.extend(t.a).extend(t.b).extend(t.c);
    centers.extend(t.a + t.b + t.c);
  }
  node.first = first;
  node.last = last;
  nodes_.push_back(node);
  if (last - first <= kMaxLeaf) return index;
  Eigen::Index axis = 0;
  centers.sizes().maxCoeff(&axis);
  const std::uint32_t middle = first + (last - first) / 2;
  std::nth_element(triangles_.begin() + first, triangles_.begin() + middle,
                   triangles_.begin() + last, [axis](const Triangle& p, const Triangle& q) {
                     return p.a[axis] + p.b[axis] + p.c[axis] < q.a[axis] + q.b[axis] + q.c[axis];
                   });
  Build(first, middle);
  const std::uint32_t right = Build(middle, last);
  nodes_[index].right = right;
  return index;
}

double TriangleTree::SquaredDistance(const Triangle& t, const Eigen::Vector3d& point) {
  const Eigen::Vector3d normal = (t.b - t.a).cross(t.c - t.a);
  const double squared_area = normal.squaredNorm();
  const auto is_inside = [&](const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
    return (to - from).cross(point - from).dot(normal) >= 0;
  };
  if (squared_area > 0 && is_inside(t.a, t.b) && is_inside(t.b, t.c) && is_inside(t.c, t.a)) {
    const double height = normal.dot(point - t.a);
    return height * height / squared_area;
  }
  return std::min({SquaredDistanceToSegment(t.a, t.b, point),
                   SquaredDistanceToSegment(t.b, t.c, point),
                   SquaredDistanceToSegment(t.c, t.a, point)});
}

void TriangleTree::Search(std::uint32_t index, const Eigen::Vector3d& point, double* least) const {
  const Node& node = nodes_[index];
  if (node.right == 0) {
    for (std::uint32_t i = node.first; i < node.last; ++i)
      *least = std::min(*least, SquaredDistance(triangles_[i], point));
    return;
  }
  std::uint32_t near = index + 1, far = node.right;
  double to_near = nodes_[near].box.squaredExteriorDistance(point);
  double to_far = nodes_[far].box.squaredExteriorDistance(point);
  if (to_far < to_near) {
    std::swap(near, far);
    std::swap(to_near, to_far);
  }
  if (to_near < *least) Search(near, point, least);
  if (to_far < *least) Search(far, point, least);
}

double TriangleTree::Distance(const Eigen::Vector3d& point) const {
  double least = std::numeric_limits<double>::infinity();
  Search(0, point, &least);
  return std::sqrt(least);
}

std::vector<Eigen::Vector3f> TriangleTree::Sample(double spacing_m, std::size_t max_points) const {
  std::vector<double> area_until;  // sums of the areas, m^2
  double sum_m2 = 0;
  for (const Triangle& t : triangles_) {
    sum_m2 += 0.5 * (t.b - t.a).cross(t.c - t.a).norm();
    area_until.push_back(sum_m2);
  }
  ThrowIf(!(sum_m2 > 0), "the area of the mesh is 0");
  const double wanted = std::ceil(sum_m2 / (spacing_m * spacing_m));
  const auto count = static_cast<std::size_t>(std::min(wanted, static_cast<double>(max_points)));
  std::vector<Eigen::Vector3f> points;
  points.reserve(count);
  std::size_t triangle = 0, in_triangle = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double area = (static_cast<double>(i) + 0.5) * sum_m2 / static_cast<double>(count);
    while (triangle + 1 < triangles_.size() && area_until[triangle] < area) {
      ++triangle;
      in_triangle = 0;
    }
    // Additive recurrence with the plastic number: low discrepancy in the unit square.
    ++in_triangle;
    double unused = 0;
    double u = std::modf(0.7548776662466927 * static_cast<double>(in_triangle), &unused);
    double v = std::modf(0.5698402909980532 * static_cast<double>(in_triangle), &unused);
    if (u + v > 1) {
      u = 1 - u;
      v = 1 - v;
    }
    const Triangle& t = triangles_[triangle];
    points.emplace_back((t.a + u * (t.b - t.a) + v * (t.c - t.a)).cast<float>());
  }
  return points;
}

}  // namespace surfit
