#include "surfit/mesh/triangle_mesh.h"

#include <limits>

#include "surfit/core/error.h"

namespace surfit {
namespace {

constexpr std::uint32_t kGone = std::numeric_limits<std::uint32_t>::max();

// Removes and moves values in place. place[i]: new index of value i, at most i; kGone: value i is
// removed.
template <typename T>
void Move(const std::vector<std::uint32_t>& place, std::size_t count, std::vector<T>* values) {
  if (values->empty()) return;
  for (std::size_t i = 0; i < place.size(); ++i)
    if (place[i] != kGone) (*values)[place[i]] = (*values)[i];
  values->resize(count);
}

}  // namespace

void KeepTriangles(const std::vector<std::uint8_t>& kept, TriangleMesh* mesh) {
  ThrowIf(kept.size() != mesh->triangles.size(), "there are ", kept.size(), " marks for ",
          mesh->triangles.size(), " triangles, must be equal");
  std::vector<std::uint32_t> place(mesh->vertices.size(), kGone);
  std::size_t triangles = 0;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    if (kept[i] == 0) continue;
    for (const std::uint32_t v : mesh->triangles[i]) place[v] = 0;
    mesh->triangles[triangles++] = mesh->triangles[i];
  }
  mesh->triangles.resize(triangles);
  std::uint32_t vertices = 0;
  for (std::uint32_t& at : place) at = at == kGone ? kGone : vertices++;
  Move(place, vertices, &mesh->vertices);
  Move(place, vertices, &mesh->normals);
  Move(place, vertices, &mesh->colors);
  for (TriangleMesh::Triangle& t : mesh->triangles)
    for (std::uint32_t& v : t) v = place[v];
}

}  // namespace surfit
