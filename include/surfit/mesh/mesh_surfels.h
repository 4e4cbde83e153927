#pragma once

#include <cmath>
#include <cstddef>
#include <functional>
#include <string>

#include "surfit/io/point_cloud.h"
#include "surfit/mesh/triangle_mesh.h"

namespace surfit {

class OptionVisitor;

// Options of MeshSurfels().
struct MeshOptions {
  double cell_m = 0.008;  // grid cell size, approximately the edge length of triangles
  // Surfels are smoothed until the noise of their normals is about this angle. The radius follows
  // from the noise and the spacing of the surfels. 0: no smoothing.
  double normal_noise_rad = M_PI / 60;
  // Distance that the surface extends beyond its surfels, in surfel radii. It is limited to
  // `trim_distance_m`, which is the distance for clouds without radii.
  double support_radii = 2;
  double trim_distance_m = 0.02;
  double min_component_m =
      0.1;  // minimum bounding-box diagonal of connected components; 0: keep all
  std::size_t max_triangles = 0;  // 0: no limit
  // Fills all holes, so that each edge belongs to two triangles. Triangles that fill holes are
  // added after decimation to `max_triangles`.
  bool watertight = false;

  void Visit(OptionVisitor& visitor);
};

// Statistics of MeshSurfels().
struct MeshSummary {
  std::size_t components_dropped = 0, triangles_dropped = 0;  // below `min_component_m`
  std::size_t pieces = 0;                                     // connected components of the mesh
  std::size_t triangles_found = 0;                            // before decimation
  double decimation_m = 0;                                    // surface error of the decimation, m
  // With `watertight`: filled holes and their triangles, removed triangles at non-manifold edges,
  // and the perimeter of the largest hole.
  std::size_t holes_filled = 0, triangles_added = 0, triangles_cut = 0;
  double longest_hole_perimeter_m = 0;
  // Distances of points to the mesh before decimation, along the mesh normals: median and 90 %
  // quantile. Only points within 3 cells of a mesh vertex are included. `covered` is their ratio.
  double median_distance_m = 0, p90_distance_m = 0, covered = 0;
};

// Progress callback: name of the stage, and completed ratio of the whole work. Calls come from any
// thread, one at a time.
using MeshProgress = std::function<void(const std::string& stage, double share)>;

// Computes a triangle mesh from a cloud with normals. Holes remain, except with `watertight`.
// Points must be finite (RemoveNonFinite()). Points without a normal of about unit length, or with
// a radius of 0, are ignored. Radii and confidences are used if the cloud has them. The result does
// not depend on the number of threads. Throws InputError for invalid options, for a cloud without
// normals, if cells are too small for the extent of the cloud, and if there is no triangle.
TriangleMesh MeshSurfels(const PointCloud& cloud, const MeshOptions& options, MeshSummary* summary,
                         const MeshProgress& progress = {});

}  // namespace surfit
