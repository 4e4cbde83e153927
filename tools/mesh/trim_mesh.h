#pragma once

#include <open3d/geometry/TriangleMesh.h>

#include <cstddef>

#include "mesh/poisson_mesh.h"

namespace surfit::tools {

// Removes the triangles that no point of the cloud supports (MeshOptions), and the vertices that no
// triangle is left of; returns how many triangles. The cloud's points and normals must be finite.
std::size_t TrimMesh(const PointCloud& cloud, const MeshOptions& options,
                     open3d::geometry::TriangleMesh* mesh);

}  // namespace surfit::tools
