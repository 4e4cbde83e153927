#pragma once

#include <functional>
#include <vector>

#include "mesh/surface/distance_field.h"
#include "mesh/surface/surfel_cubes.h"
#include "surfit/mesh/mesh_surfels.h"
#include "surfit/mesh/triangle_mesh.h"

namespace surfit {

// The steps of MeshSurfels(), in their order.

// Finds the standard deviations of surfels along their normals, which are known but for a common
// factor: by how far the surfels around each are off a plane, the median of which is the factor.
// Where they are farther off than it says they count as noisier.
void FindSigmas(std::vector<MeshSurfel>* surfels);

// Moves surfels along their normals into planes fitted to those around them that face the same way
// and lie within their noise, weighted by 1 / sigma^2, and gives them the planes' normals. Each
// looks so far around that, by sigma and spacing, its normal comes out to normal_noise_rad.
// `done` is called from any thread with the share of the surfels that a part of them is.
void SmoothSurfels(double normal_noise_rad, const std::function<void(double)>& done,
                   std::vector<MeshSurfel>* surfels);

// The surface where the field is zero, by dual marching cubes (Nielson 2004): a vertex for each
// patch of the surface in a cell, moved onto the zero of the field, with normal and colour of the
// surfels around it, and two triangles around each edge of the grid that the surface cuts. Only
// where the surfels' normals say, as the field does, which side was seen, and where a surfel
// reaches. `done` is called from any thread with a share of the work.
TriangleMesh ExtractSurface(const DistanceField& field, const SurfelCubes& surfels,
                            const std::function<void(double)>& done);

// Leaves out what hangs together by shared vertices and whose bounding box has a shorter diagonal
// than that. Counts in the summary what goes, and the pieces that stay.
void DropSmallPieces(double min_piece_m, MeshSummary* summary, TriangleMesh* mesh);

// Leaves at most so many triangles, by collapsing edges where the surface changes least (Garland
// and Heckbert 1997), which keeps borders and pieces. Returns by how much it has changed, metres.
double Decimate(std::size_t max_triangles, TriangleMesh* mesh);

// Makes every edge one of two triangles that go along it in opposite directions. Triangles at edges
// that more than two have, or two in the same direction, are left out; vertices where several parts
// of the surface touch become several; and each hole is filled: from its rim inwards by rings of
// half as many vertices each, which are new, and in the end by a triangle or a fan. A sheet has one
// hole, its outline, and so gets a back. The new vertices have normals and colours if the others
// do.
void CloseHoles(MeshSummary* summary, TriangleMesh* mesh);

}  // namespace surfit
