#pragma once

#include <cmath>
#include <cstddef>
#include <functional>
#include <string>

#include "surfit/io/point_cloud.h"
#include "surfit/mesh/triangle_mesh.h"

namespace surfit {

class OptionVisitor;

// How fine a mesh is, how smooth, and how far it reaches.
struct MeshOptions {
  double cell_m = 0.008;  // of the grid that the surface is found in: about a triangle's side
  // Surfels are smoothed over a distance at which noise tilts them by this much, as far as noise
  // and their spacing tell; 0 = not.
  double normal_noise_rad = M_PI / 60;
  // A surface goes on beside its surfels by so many of their radii, but no farther than
  // trim_distance_m; by this alone where the cloud has no radii.
  double support_radii = 2;
  double trim_distance_m = 0.02;
  double min_piece_m = 0.1;       // loose pieces that are smaller across are left out; 0 = none
  std::size_t max_triangles = 0;  // 0 = no limit
  // Fills all holes, besides max_triangles: each edge is one of two triangles.
  bool watertight = false;

  void Visit(OptionVisitor& visitor);
};

// What was made of a cloud.
struct MeshSummary {
  std::size_t pieces_dropped = 0, triangles_dropped = 0;  // loose ones, below min_piece_m
  std::size_t pieces = 0;                                 // that are left
  std::size_t triangles_found = 0;                        // of these pieces, before decimation
  double decimation_m = 0;                                // that these have moved the surface by
  // Of a watertight mesh: what was made up where nothing was seen, the length of the longest rim of
  // a hole, and triangles that were cut out where more than two met at an edge.
  std::size_t holes_filled = 0, triangles_added = 0, triangles_cut = 0;
  double longest_rim_m = 0;
  // From the points to the mesh before it, along its normals: half and nine tenths are no farther.
  // Of points with mesh within 3 cells, the share of which is `covered`.
  double median_distance_m = 0, p90_distance_m = 0, covered = 0;
};

// Called with what is being done, and which share of all that is done by now.
using MeshProgress = std::function<void(const std::string& stage, double share)>;

// The surface of a cloud with normals as triangles, where there are points: holes stay. Radii and
// confidences count where the cloud has them. The result does not depend on the number of threads.
// Throws InputError if the options are not valid, the cloud has no normals, cells are too small
// for its extent, or no triangle is found.
TriangleMesh MeshSurfels(const PointCloud& cloud, const MeshOptions& options, MeshSummary* summary,
                         const MeshProgress& progress = {});

}  // namespace surfit
