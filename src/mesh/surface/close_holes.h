#pragma once

#include "surfit/mesh/mesh_surfels.h"
#include "surfit/mesh/triangle_mesh.h"

namespace surfit {

// Makes every edge one of two triangles that go along it in opposite directions. Triangles at edges
// that more than two have, or two in the same direction, are left out; vertices where several parts
// of the surface touch become several; and each hole is filled: from its rim inwards by rings of
// half as many vertices each, which are new, and in the end by a triangle or a fan. A sheet has one
// hole, its outline, and so gets a back. The new vertices have normals and colours if the others
// do.
void CloseHoles(MeshSummary* summary, TriangleMesh* mesh);

}  // namespace surfit
