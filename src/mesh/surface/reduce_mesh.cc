#include <meshoptimizer.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <numeric>
#include <vector>

#include "mesh/mesh_steps.h"

namespace surfit {
namespace {

// Union-find of connected vertices. The vertex of smallest index represents a set.
class VertexSets {
 public:
  explicit VertexSets(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), 0u);
  }
  std::uint32_t Find(std::uint32_t v) {
    while (parent_[v] != v) v = parent_[v] = parent_[parent_[v]];
    return v;
  }
  void Join(std::uint32_t v, std::uint32_t w) {
    v = Find(v);
    w = Find(w);
    parent_[std::max(v, w)] = std::min(v, w);
  }

 private:
  std::vector<std::uint32_t> parent_;
};

}  // namespace

void DropSmallPieces(double min_component_m, MeshSummary* summary, TriangleMesh* mesh) {
  VertexSets sets(mesh->vertices.size());
  for (const TriangleMesh::Triangle& t : mesh->triangles) {
    sets.Join(t[0], t[1]);
    sets.Join(t[0], t[2]);
  }
  std::vector<Eigen::AlignedBox3f> boxes(mesh->vertices.size());
  for (std::uint32_t v = 0; v < mesh->vertices.size(); ++v)
    boxes[sets.Find(v)].extend(mesh->vertices[v]);
  const auto is_kept = [&](std::uint32_t v) {
    return boxes[sets.Find(v)].diagonal().norm() >= min_component_m;
  };
  for (std::uint32_t v = 0; v < mesh->vertices.size(); ++v) {
    if (sets.Find(v) == v) ++(is_kept(v) ? summary->pieces : summary->components_dropped);
  }
  std::vector<std::uint8_t> kept(mesh->triangles.size());
  for (std::size_t i = 0; i < kept.size(); ++i) {
    kept[i] = is_kept(mesh->triangles[i][0]) ? 1 : 0;
    summary->triangles_dropped += 1 - kept[i];
  }
  KeepTriangles(kept, mesh);
}

double Decimate(std::size_t max_triangles, TriangleMesh* mesh) {
  if (mesh->triangles.size() <= max_triangles) return 0;
  constexpr float kAnyError = std::numeric_limits<float>::max();
  const std::size_t most = 3 * max_triangles;
  const float* vertices = mesh->vertices.front().data();
  const std::size_t count = mesh->vertices.size(), stride = sizeof(mesh->vertices.front());
  const float scale_m = meshopt_simplifyScale(vertices, count, stride);
  static_assert(sizeof(TriangleMesh::Triangle) == 3 * sizeof(unsigned int));
  std::vector<unsigned int> indices(3 * mesh->triangles.size());
  std::copy_n(mesh->triangles.front().data(), indices.size(), indices.data());
  float error = 0, further_error = 0;
  indices.resize(meshopt_simplify(indices.data(), indices.data(), indices.size(), vertices, count,
                                  stride, most, kAnyError, 0, &error));
  // Clusters vertices if edge collapses do not reach the requested size.
  if (indices.size() > most) {
    indices.resize(meshopt_simplifySloppy(indices.data(), indices.data(), indices.size(), vertices,
                                          count, stride, most, kAnyError, &further_error));
  }
  mesh->triangles.resize(indices.size() / 3);
  std::copy_n(indices.data(), indices.size(), mesh->triangles.front().data());
  KeepTriangles(std::vector<std::uint8_t>(mesh->triangles.size(), 1), mesh);
  return scale_m * (error + further_error);
}

}  // namespace surfit
