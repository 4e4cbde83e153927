#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "mesh/mesh_steps.h"
#include "surfit/mapping/surfel_block.h"

namespace surfit {
namespace {

using Triangle = TriangleMesh::Triangle;
constexpr std::uint32_t kNoSide = std::numeric_limits<std::uint32_t>::max();

// Side 3 i + k is the edge from corner k of triangle i to the next corner.
std::uint32_t NextSide(std::uint32_t side) { return side % 3 == 2 ? side - 2 : side + 1; }
std::uint32_t LastSide(std::uint32_t side) { return side % 3 == 0 ? side + 2 : side - 1; }

std::uint32_t BeginOf(const std::vector<Triangle>& triangles, std::uint32_t side) {
  return triangles[side / 3][side % 3];
}

// Adjacency of triangle sides. The opposite side is the same edge in the adjacent triangle.
struct Sides {
  std::vector<std::uint32_t> opposite;  // kNoSide: none
  // Per triangle. 0: more than two triangles share an edge, or two triangles traverse an edge in
  // the same direction.
  std::vector<std::uint8_t> is_manifold;
};

Sides PairSides(const std::vector<Triangle>& triangles) {
  struct Edge {
    std::uint64_t vertices;
    std::uint32_t side;
  };
  const auto count = static_cast<std::uint32_t>(3 * triangles.size());
  std::vector<Edge> edges(count);
  Sides sides = {std::vector<std::uint32_t>(count, kNoSide),
                 std::vector<std::uint8_t>(triangles.size(), 1)};
  for (std::uint32_t side = 0; side < count; ++side) {
    const std::uint32_t a = BeginOf(triangles, side), b = BeginOf(triangles, NextSide(side));
    edges[side] = {std::uint64_t{std::min(a, b)} << 32 | std::max(a, b), side};
    if (a == b) sides.is_manifold[side / 3] = 0;
  }
  std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) {
    return std::make_pair(a.vertices, a.side) < std::make_pair(b.vertices, b.side);
  });
  for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
    while (end < edges.size() && edges[end].vertices == edges[begin].vertices) ++end;
    const std::uint32_t a = edges[begin].side, b = edges[end - 1].side;
    if (end - begin == 2 && BeginOf(triangles, a) != BeginOf(triangles, b)) {
      sides.opposite[a] = b;
      sides.opposite[b] = a;
    } else if (end - begin > 1) {
      for (std::size_t i = begin; i < end; ++i) sides.is_manifold[edges[i].side / 3] = 0;
    }
  }
  return sides;
}

// Removes non-manifold triangles repeatedly until all triangles are manifold.
Sides KeepManifoldTriangles(MeshSummary* summary, TriangleMesh* mesh) {
  while (true) {
    Sides sides = PairSides(mesh->triangles);
    const auto unusual = std::count(sides.is_manifold.begin(), sides.is_manifold.end(), 0);
    if (unusual == 0) return sides;
    summary->triangles_cut += static_cast<std::size_t>(unusual);
    KeepTriangles(sides.is_manifold, mesh);
  }
}

std::uint32_t CopyVertex(std::uint32_t vertex, TriangleMesh* mesh) {
  mesh->vertices.push_back(mesh->vertices[vertex]);
  if (!mesh->normals.empty()) mesh->normals.push_back(mesh->normals[vertex]);
  if (!mesh->colors.empty()) mesh->colors.push_back(mesh->colors[vertex]);
  return static_cast<std::uint32_t>(mesh->vertices.size() - 1);
}

// Duplicates each vertex that joins several triangle fans, so that each fan has its own vertex.
void SeparateFans(const Sides& sides, TriangleMesh* mesh) {
  std::vector<std::uint8_t> is_taken(mesh->vertices.size()), is_done(sides.opposite.size());
  for (std::uint32_t first = 0; first < is_done.size(); ++first) {
    if (is_done[first] != 0) continue;
    const std::uint32_t vertex = BeginOf(mesh->triangles, first);
    std::uint32_t start = first;
    while (sides.opposite[start] != kNoSide) {
      start = NextSide(sides.opposite[start]);
      if (start == first) break;
    }
    const std::uint32_t own = is_taken[vertex] == 0 ? vertex : CopyVertex(vertex, mesh);
    is_taken[vertex] = 1;
    for (std::uint32_t side = start; side != kNoSide && is_done[side] == 0;
         side = sides.opposite[LastSide(side)]) {
      is_done[side] = 1;
      mesh->triangles[side / 3][side % 3] = own;
    }
  }
}

// Boundary vertices of each hole, in the orientation of the triangles that will fill the hole.
std::vector<std::vector<std::uint32_t>> FindRims(const Sides& sides, const TriangleMesh& mesh) {
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> before(mesh.vertices.size(), kNone);
  for (std::uint32_t side = 0; side < sides.opposite.size(); ++side) {
    if (sides.opposite[side] != kNoSide) continue;
    before[BeginOf(mesh.triangles, NextSide(side))] = BeginOf(mesh.triangles, side);
  }
  std::vector<std::vector<std::uint32_t>> rims;
  for (std::uint32_t first = 0; first < before.size(); ++first) {
    if (before[first] == kNone) continue;
    rims.emplace_back();
    for (std::uint32_t vertex = first; before[vertex] != kNone;) {
      rims.back().push_back(vertex);
      vertex = std::exchange(before[vertex], kNone);
    }
  }
  return rims;
}

class HoleFiller {
 public:
  HoleFiller(std::vector<std::uint32_t> rim, TriangleMesh* mesh)
      : ring_(std::move(rim)), mesh_(*mesh) {
    for (const std::uint32_t v : ring_) center_ += mesh_.vertices[v];
    center_ /= static_cast<float>(ring_.size());
  }

  void Fill() {
    constexpr std::size_t kFewest = 6;
    while (ring_.size() > kFewest) AddRing();
    if (ring_.size() == 3) {
      mesh_.triangles.push_back({ring_[0], ring_[1], ring_[2]});
      return;
    }
    const std::uint32_t middle = Add(ring_, center_);
    for (std::size_t i = 0; i < ring_.size(); ++i)
      mesh_.triangles.push_back({At(i), At(i + 1), middle});
  }

 private:
  std::uint32_t At(std::size_t i) const { return ring_[i % ring_.size()]; }

  std::uint32_t Add(const std::vector<std::uint32_t>& others, const Eigen::Vector3f& position) {
    Eigen::Vector3f normal = Eigen::Vector3f::Zero(), color = Eigen::Vector3f::Zero();
    for (const std::uint32_t v : others) {
      if (!mesh_.normals.empty()) normal += mesh_.normals[v];
      if (mesh_.colors.empty()) continue;
      color += Eigen::Vector3f(mesh_.colors[v].r, mesh_.colors[v].g, mesh_.colors[v].b);
    }
    mesh_.vertices.push_back(position);
    if (!mesh_.normals.empty()) {
      mesh_.normals.push_back(normal.norm() > 0 ? normal.normalized()
                                                : Eigen::Vector3f(Eigen::Vector3f::UnitZ()));
    }
    if (!mesh_.colors.empty())
      mesh_.colors.push_back(ToRgb8(color / static_cast<float>(others.size())));
    return static_cast<std::uint32_t>(mesh_.vertices.size() - 1);
  }

  // Adds an inner ring with half the vertices of the outer ring, rounded up. The distance between
  // both rings is the height of an equilateral triangle on an outer edge.
  void AddRing() {
    std::vector<std::uint32_t> inner;
    for (std::size_t i = 0; i < ring_.size(); i += 2) {
      const std::vector<std::uint32_t> pair = {At(i), At(std::min(i + 1, ring_.size() - 1))};
      const Eigen::Vector3f &a = mesh_.vertices[pair[0]], &b = mesh_.vertices[pair[1]];
      const Eigen::Vector3f middle = (a + b) / 2, inwards = center_ - middle;
      const float step_m = 0.87f * (mesh_.vertices[At(i + 2)] - a).norm() / 2;
      const float share = std::min(1.f, step_m / std::max(inwards.norm(), 1e-9f));
      inner.push_back(Add(pair, middle + share * inwards));
    }
    for (std::size_t k = 0; k < inner.size(); ++k) {
      const std::size_t i = 2 * k, end = std::min(i + 2, ring_.size());
      const std::uint32_t next = inner[(k + 1) % inner.size()];
      if (i + 1 < ring_.size()) mesh_.triangles.push_back({At(i), At(i + 1), inner[k]});
      mesh_.triangles.push_back({At(end - 1), At(end), next});
      mesh_.triangles.push_back({At(end - 1), next, inner[k]});
    }
    ring_ = std::move(inner);
  }

  std::vector<std::uint32_t> ring_;
  TriangleMesh& mesh_;
  Eigen::Vector3f center_ = Eigen::Vector3f::Zero();
};

}  // namespace

void CloseHoles(MeshSummary* summary, TriangleMesh* mesh) {
  const Sides sides = KeepManifoldTriangles(summary, mesh);
  SeparateFans(sides, mesh);
  const std::size_t before = mesh->triangles.size();
  for (std::vector<std::uint32_t>& rim : FindRims(sides, *mesh)) {
    double length_m = 0;
    for (std::size_t i = 0; i < rim.size(); ++i)
      length_m += (mesh->vertices[rim[(i + 1) % rim.size()]] - mesh->vertices[rim[i]]).norm();
    summary->longest_hole_perimeter_m = std::max(summary->longest_hole_perimeter_m, length_m);
    ++summary->holes_filled;
    HoleFiller(std::move(rim), mesh).Fill();
  }
  summary->triangles_added = mesh->triangles.size() - before;
}

}  // namespace surfit
