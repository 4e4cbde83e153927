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
  // Standard deviation of the normals after smoothing, approximately. The radius of the smoothed
  // neighbourhood follows from the noise and the spacing of the surfels. 0: no smoothing.
  double normal_noise_rad = M_PI / 60;
  // Maximum distance of the surface from the centre of a surfel, along the surfel, in surfel radii.
  double support_radii = 2;
  // Upper limit of this distance. Clouds without radii use this limit only.
  double trim_distance_m = 0.02;
  double min_component_m =
      0.1;  // minimum bounding-box diagonal of connected components; 0: keep all
  std::size_t max_triangles = 0;  // 0: no limit
  // Fills all holes, so that each edge belongs to two triangles. The outline of an open sheet is a
  // hole as well. Holes are filled after decimation, so the mesh can exceed `max_triangles`.
  bool watertight = false;

  void Visit(OptionVisitor& visitor);
};

// Statistics of MeshSurfels().
struct MeshSummary {
  std::size_t components_dropped = 0, triangles_dropped = 0;  // below `min_component_m`
  std::size_t pieces = 0;           // remaining components, before decimation
  std::size_t triangles_found = 0;  // triangles of these components
  double decimation_m = 0;          // estimated surface error; 0: no decimation
  // With `watertight`: filled holes and their triangles, removed triangles at non-manifold edges,
  // and the longest perimeter of a hole.
  std::size_t holes_filled = 0, triangles_added = 0, triangles_cut = 0;
  double longest_hole_perimeter_m = 0;
  // Absolute distances of points to the mesh before decimation, along the mesh normals: median and
  // 90 % quantile. Only points within 3 cells of a mesh vertex are included. `covered` is the ratio
  // of these points to all points of the cloud.
  double median_distance_m = 0, p90_distance_m = 0, covered = 0;
};

// Progress callback: name of the stage, and completed ratio of the whole work. Calls come from any
// thread, one at a time. The last ratio can be below 1, because stages can be skipped.
using MeshProgress = std::function<void(const std::string& stage, double share)>;

// Computes a triangle mesh from a cloud with normals, in the frame of the cloud. The mesh has
// normals and colours; it is grey if the cloud has no colours. Holes remain, except with
// `watertight`. Points without a radius above 0, or without a normal of length 0.5 to 2, are
// ignored. Radii and confidences are used if the cloud has them. `summary` must not be null. The
// result does not depend on the number of threads. Throws InputError for
// - invalid options
// - a cloud without normals, or with an attribute of another size than `points`
// - a point that is not finite (see RemoveNonFinite()), or too far from the origin for the cell
//   size
// - a result without a triangle
TriangleMesh MeshSurfels(const PointCloud& cloud, const MeshOptions& options, MeshSummary* summary,
                         const MeshProgress& progress = {});

}  // namespace surfit
