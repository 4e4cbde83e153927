#pragma once

#include <functional>
#include <vector>

#include "mesh/surface/distance_field.h"
#include "mesh/surface/surfel_cubes.h"
#include "surfit/mesh/mesh_surfels.h"
#include "surfit/mesh/triangle_mesh.h"

namespace surfit {

// Steps of MeshSurfels(), in order of execution.

// Scales the sigmas of surfels, which are known up to a common factor. The factor is the median
// ratio of the RMS distance of neighbours from a fitted plane to sigma. Surfels with a larger
// distance get a larger sigma, up to four times the scaled one.
void FindSigmas(std::vector<MeshSurfel>* surfels);

// Moves surfels along their normals into local planes, and replaces their normals. Planes are
// fitted to neighbours with similar normals and heights within the noise, weighted by 1 / sigma^2.
// The radius of the neighbourhood follows from sigma and spacing, so that the normals have the
// standard deviation normal_noise_rad. `done` is called from several threads with the ratio of
// surfels in a finished part.
void SmoothSurfels(double normal_noise_rad, const std::function<void(double)>& done,
                   std::vector<MeshSurfel>* surfels);

// Zero level set of the field by dual marching cubes (Nielson 2004). Each surface patch in a cell
// becomes a vertex, which is moved onto the zero of the field. Its normal and colour come from
// nearby surfels. Each grid edge that the surface cuts becomes two triangles.
//
// A vertex needs a surfel within its reach, and normals that agree with the sign of the field.
// `done` is called from several threads with the ratio of finished work.
TriangleMesh ExtractSurface(const DistanceField& field, const SurfelCubes& surfels,
                            const std::function<void(double)>& done);

// Removes connected pieces whose bounding box has a diagonal below min_component_m. Counts removed
// triangles and pieces in the summary.
void DropSmallPieces(double min_component_m, MeshSummary* summary, TriangleMesh* mesh);

// Reduces the mesh to max_triangles by edge collapses with the least change (Garland and Heckbert
// 1997), which keep borders and pieces. If this is not sufficient, clusters of vertices are merged.
// Returns the geometric error, m.
double Decimate(std::size_t max_triangles, TriangleMesh* mesh);

// Makes the mesh watertight:
// 1. Removes triangles at edges with more than two triangles, or with two triangles of the same
//   direction.
// 2. Duplicates vertices where several parts of the surface touch.
// 3. Fills each hole from its rim inwards by rings with half the number of vertices, and by a final
//   triangle or fan.
// The outline of an open sheet is a hole, so a sheet gets a back side. New vertices get normals and
// colours if the mesh has them.
void CloseHoles(MeshSummary* summary, TriangleMesh* mesh);

}  // namespace surfit
