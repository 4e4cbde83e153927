#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <utility>

#include "mesh/mesh_steps.h"

namespace surfit::testing {
namespace {

// Each side of a triangle has exactly one neighbour with the opposite direction.
void ExpectWatertight(const TriangleMesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> sides;
  for (const TriangleMesh::Triangle& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) ++sides[{t[k], t[(k + 1) % 3]}];
  for (const auto& [side, count] : sides) {
    ASSERT_NE(side.first, side.second);
    ASSERT_EQ(count, 1) << side.first << " " << side.second;
    ASSERT_EQ(sides.count({side.second, side.first}), 1u) << side.first << " " << side.second;
  }
  ASSERT_EQ(mesh.normals.size(), mesh.vertices.size());
  ASSERT_EQ(mesh.colors.size(), mesh.vertices.size());
  for (const Eigen::Vector3f& normal : mesh.normals) ASSERT_NEAR(normal.norm(), 1, 1e-5);
}

MeshSummary Close(TriangleMesh* mesh) {
  mesh->normals.assign(mesh->vertices.size(), Eigen::Vector3f::UnitZ());
  mesh->colors.assign(mesh->vertices.size(), {10, 20, 30});
  MeshSummary summary;
  CloseHoles(&summary, mesh);
  ExpectWatertight(*mesh);
  return summary;
}

// Square grid in the plane z = 0, without cells whose centre is closer to the middle than `hole`.
TriangleMesh Grid(int cells, float hole) {
  TriangleMesh mesh;
  for (int v = 0; v <= cells; ++v)
    for (int u = 0; u <= cells; ++u) mesh.vertices.emplace_back(u, v, 0);
  const auto at = [&](int u, int v) { return static_cast<std::uint32_t>(v * (cells + 1) + u); };
  for (int v = 0; v < cells; ++v) {
    for (int u = 0; u < cells; ++u) {
      const float middle = 0.5f * static_cast<float>(cells - 1);
      if (std::hypot(static_cast<float>(u) - middle, static_cast<float>(v) - middle) < hole)
        continue;
      mesh.triangles.push_back({at(u, v), at(u + 1, v), at(u + 1, v + 1)});
      mesh.triangles.push_back({at(u, v), at(u + 1, v + 1), at(u, v + 1)});
    }
  }
  KeepTriangles(std::vector<std::uint8_t>(mesh.triangles.size(), 1), &mesh);
  return mesh;
}

double AreaOf(const TriangleMesh& mesh, std::size_t from) {
  double area = 0;
  for (std::size_t i = from; i < mesh.triangles.size(); ++i) {
    const auto& t = mesh.triangles[i];
    const Eigen::Vector3f& a = mesh.vertices[t[0]];
    area += 0.5 * (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).norm();
  }
  return area;
}

// The boundary of a sheet is one loop, and a hole adds a second loop. Both are filled in the plane:
// 40 x 40 for the outline, and at least 4 r^2 for the hole.
TEST(CloseHoles, FillsHoleAndOutlineOfSheet) {
  TriangleMesh mesh = Grid(40, 10);
  const std::size_t seen = mesh.triangles.size();
  const double hole = 1600 - AreaOf(mesh, 0);
  const MeshSummary summary = Close(&mesh);
  EXPECT_EQ(summary.holes_filled, 2u);
  EXPECT_EQ(summary.triangles_cut, 0u);
  EXPECT_EQ(summary.triangles_added, mesh.triangles.size() - seen);
  EXPECT_NEAR(summary.longest_hole_perimeter_m, 160, 1e-3);
  EXPECT_NEAR(AreaOf(mesh, seen), 1600 + hole, 0.02 * 1900);
  for (const Eigen::Vector3f& vertex : mesh.vertices) EXPECT_EQ(vertex.z(), 0);
  for (const Rgb8 color : mesh.colors) EXPECT_TRUE(color == Rgb8({10, 20, 30}));
  // Successive rings have fewer vertices: about three times as many triangles as boundary vertices.
  EXPECT_LT(summary.triangles_added, 4 * (160 + 80u));
}

TEST(CloseHoles, KeepsClosedSurface) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  const TriangleMesh before = mesh;
  const MeshSummary summary = Close(&mesh);
  EXPECT_EQ(mesh.triangles, before.triangles);
  EXPECT_EQ(mesh.vertices, before.vertices);
  EXPECT_EQ(summary.triangles_added, 0u);
}

TEST(CloseHoles, SplitsSharedVertex) {
  TriangleMesh mesh;  // two triangles
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {-1, 0, 0}, {-1, -1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 3, 4}};
  const MeshSummary summary = Close(&mesh);
  EXPECT_EQ(mesh.vertices.size(), 6u);
  EXPECT_EQ(summary.holes_filled, 2u);
  EXPECT_EQ(mesh.triangles.size(), 4u);
}

// Three triangles at one edge, and one triangle with reversed orientation.
TEST(CloseHoles, RemovesTrianglesAtNonManifoldEdge) {
  TriangleMesh mesh = Grid(4, 0);
  mesh.vertices.emplace_back(2.f, 2.f, 1.f);
  mesh.triangles.push_back({12, 13, 25});
  std::swap(mesh.triangles[0][0], mesh.triangles[0][1]);
  const MeshSummary summary = Close(&mesh);
  EXPECT_GE(summary.triangles_cut, 3u + 2u);
  EXPECT_LE(summary.triangles_cut, 8u);
}

TEST(CloseHoles, ClosesBoundaryLoopsOfAnyLength) {
  for (int cells = 1; cells < 12; ++cells) {
    TriangleMesh mesh = Grid(cells, 0);
    EXPECT_EQ(Close(&mesh).holes_filled, 1u) << cells;
  }
}

}  // namespace
}  // namespace surfit::testing
