#pragma once

#include <functional>
#include <vector>

#include "mesh/surface/distance_field.h"
#include "mesh/surface/surfel_cubes.h"
#include "surfit/mesh/mesh_surfels.h"
#include "surfit/mesh/triangle_mesh.h"

namespace surfit {

// Steps of MeshSurfels(), in order of execution.

// Scales the relative sigmas of surfels to m. The scale is the median ratio of the RMS distance
// from local planes to sigma. A larger local RMS distance replaces the scaled sigma, up to 4 times
// this sigma. At last, 0.5 mm is added in quadrature. The vector must not be empty.
void FindSigmas(std::vector<MeshSurfel>* surfels);

// Moves surfels along their normals into local planes, and replaces their normals. Planes are
// fitted to neighbours with similar normals and heights, weighted by 1 / sigma^2. The radius of the
// neighbourhood gives normals with the standard deviation normal_noise_rad. Surfels without a plane
// stay. Requires sigmas in m (call FindSigmas() first), normal_noise_rad > 0 and at least one
// surfel.
//
// `done` is called from several threads and must be thread-safe. Each call passes the fraction of
// the work completed since the previous call. The fractions add up to 1.
void SmoothSurfels(double normal_noise_rad, const std::function<void(double)>& done,
                   std::vector<MeshSurfel>* surfels);

// Zero level set of the field by dual marching cubes (Nielson 2004). Each surface patch in a cell
// becomes a vertex with normal and colour of nearby surfels.
//
// A vertex needs a nearby surfel whose normal agrees with the sign of the field. `surfels` must be
// those of the field. `done` is called as by SmoothSurfels().
TriangleMesh ExtractSurface(const DistanceField& field, const SurfelCubes& surfels,
                            const std::function<void(double)>& done);

// Removes connected components with a bounding-box diagonal below min_component_m. Counts removed
// and remaining components in the summary.
void DropSmallPieces(double min_component_m, MeshSummary* summary, TriangleMesh* mesh);

// Reduces the mesh to max_triangles by edge collapses (Garland and Heckbert 1997), which keep
// borders and components. If necessary, then merges clusters of vertices. Returns the geometric
// error, m. 0 if the mesh is small enough. Requires max_triangles > 0.
double Decimate(std::size_t max_triangles, TriangleMesh* mesh);

// Makes the mesh watertight:
// 1. Removes triangles at edges with more than two triangles, or with two triangles of the same
//   direction.
// 2. Duplicates vertices where several parts of the surface touch.
// 3. Fills each hole from its rim inwards. An open sheet gets a back side. New vertices get normals
//    and colours if the mesh has them.
void CloseHoles(MeshSummary* summary, TriangleMesh* mesh);

}  // namespace surfit
