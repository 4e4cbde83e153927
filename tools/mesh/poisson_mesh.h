#pragma once

#include <cstddef>
#include <string>

#include "surfit/core/options.h"
#include "surfit/io/point_cloud.h"

namespace surfit::tools {

// How fine a mesh is, and how far it reaches. A triangle is kept where each place of it (corners,
// middles of sides, centre) has a point within trim_distance_m that supports it: whose disc, where
// the cloud has radii, grown support_radii times, is at most cell_m away along its normal.
struct MeshOptions {
  double cell_m = 0.01;  // size of the finest cells; triangles are about as large
  double trim_distance_m = 0.02;
  double support_radii = 2;  // neighbours stand less than two radii apart

  void Visit(OptionVisitor& visitor);
};

// What a mesh has.
struct MeshSummary {
  std::size_t vertices = 0;
  std::size_t triangles = 0;
  std::size_t triangles_trimmed = 0;  // that the cloud does not support
};

// Writes a triangle mesh of the cloud's surface as .ply (binary) or .obj, with the cloud's colours:
// screened Poisson reconstruction (Kazhdan and Hoppe, 2013) by Open3D, which closes every surface,
// and then trimmed to what the cloud supports. All points must be finite. The same cloud gives the
// same mesh. Throws InputError if the options are not valid, the cloud has no normals or no extent,
// no triangle is left, or the file cannot be written.
MeshSummary WritePoissonMesh(const PointCloud& cloud, const MeshOptions& options,
                             const std::string& path);

}  // namespace surfit::tools
