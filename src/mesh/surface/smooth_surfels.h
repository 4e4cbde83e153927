#pragma once

#include <functional>
#include <vector>

#include "mesh/surface/surfel_cubes.h"

namespace surfit {

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

}  // namespace surfit
