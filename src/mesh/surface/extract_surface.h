#pragma once

#include <functional>

#include "mesh/surface/distance_field.h"
#include "mesh/surface/surfel_cubes.h"
#include "surfit/mesh/triangle_mesh.h"

namespace surfit {

// The surface where the field is zero, by dual marching cubes (Nielson 2004): a vertex for each
// patch of the surface in a cell, moved onto the zero of the field, with normal and colour of the
// surfels around it, and two triangles around each edge of the grid that the surface cuts. Only
// where the surfels' normals say, as the field does, which side was seen, and where a surfel
// reaches. `done` is called from any thread with a share of the work.
TriangleMesh ExtractSurface(const DistanceField& field, const SurfelCubes& surfels,
                            const std::function<void(double)>& done);

}  // namespace surfit
