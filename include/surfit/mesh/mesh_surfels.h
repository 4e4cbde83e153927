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
  double cell_m = 0.008;  // grid cell size, about the edge length of triangles
  // Approximate standard deviation of the smoothed normals, rad. The radius of the smoothed
  // neighbourhood depends on noise and spacing of the surfels. 0: no smoothing.
  double normal_noise_rad = M_PI / 60;
  // Maximum distance of the surface from a surfel centre, in surfel radii.
  double support_radii = 2;
  // Upper limit of this distance, m. It is the only limit for clouds without radii.
  double trim_distance_m = 0.02;
  double min_component_m =
      0.1;  // minimum bounding-box diagonal of a connected component; 0: keep all
  std::size_t max_triangles = 0;  // 0: no limit
  // Fills all holes, so that each edge has two triangles. The outline of an open sheet is a hole,
  // too. The filled mesh can exceed `max_triangles`.
  bool watertight = false;

  void Visit(OptionVisitor& visitor);
};

// Statistics of MeshSurfels().
struct MeshSummary {
  std::size_t components_dropped = 0, triangles_dropped = 0;  // below `min_component_m`
  std::size_t pieces = 0;           // connected components before decimation
  std::size_t triangles_found = 0;  // triangles before decimation
  double decimation_m = 0;          // estimated surface error of the decimation; 0: no decimation
  // With `watertight`: holes and their triangles, removed triangles at non-manifold edges, and
  // longest perimeter of a hole.
  std::size_t holes_filled = 0, triangles_added = 0, triangles_cut = 0;
  double longest_hole_perimeter_m = 0;
  // Distances of points to the mesh before decimation, along the mesh normals: median and 90 %
  // quantile. Only points within 3 cells of a vertex are included. `covered`: ratio of these points
  // to all points.
  double median_distance_m = 0, p90_distance_m = 0, covered = 0;
};

// Progress callback: name of the stage, and completed ratio of all work. Called from any thread,
// one call at a time. The last ratio can be below 1.
using MeshProgress = std::function<void(const std::string& stage, double share)>;

// Computes a triangle mesh from a cloud with normals, in the frame of the cloud, m. The mesh has
// normals and colours, or is grey if the cloud has no colours. Radii and confidences of the cloud
// are used if present. Points with a radius of at most 0, or with a normal length outside 0.5 to 2,
// are ignored. `summary` must not be null. The result does not depend on the number of threads.
//
// Throws InputError for invalid options, an empty cloud, a cloud without usable normals, and an
// empty mesh. Also throws for points that are not finite (see RemoveNonFinite()) or too far from
// the origin for the cell size. The size of each attribute must be 0 or the number of points, else
// InputError.
TriangleMesh MeshSurfels(const PointCloud& cloud, const MeshOptions& options, MeshSummary* summary,
                         const MeshProgress& progress = {});

}  // namespace surfit
