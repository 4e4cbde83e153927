#pragma once

#include "surfit/mesh/mesh_surfels.h"
#include "surfit/mesh/triangle_mesh.h"

namespace surfit {

// Leaves out what hangs together by shared vertices and whose bounding box has a shorter diagonal
// than that. Counts in the summary what goes, and the pieces that stay.
void DropSmallPieces(double min_piece_m, MeshSummary* summary, TriangleMesh* mesh);

// Leaves at most so many triangles, by collapsing edges where the surface changes least (Garland
// and Heckbert 1997), which keeps borders and pieces. Returns by how much it has changed, metres.
double Decimate(std::size_t max_triangles, TriangleMesh* mesh);

}  // namespace surfit
