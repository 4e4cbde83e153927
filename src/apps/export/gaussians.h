#pragma once

#include <string>
#include <vector>

#include "surfit/geometry/rigid3.h"
#include "surfit/mapping/surfel_block.h"

namespace surfit {

// Writes surfels as flat Gaussians in the PLY format of 3D Gaussian splatting (Kerbl et al.,
// SIGGRAPH 2023). Properties: x y z, nx ny nz, f_dc_0..2, f_rest_0..44 (0), opacity (logit),
// scale_0..2, rot_0..3 (w first). A scale is the logarithm of a standard deviation in m. The third
// axis is the normal. Throws InputError with the path if writing fails.
//
// Renderers blend the splats from front to back by their opacity, without regard to surfaces. So
// the opacity is high, and the standard deviation is a fixed ratio of the surfel radius.
void WriteGaussians(const std::vector<Surfel>& surfels, const Rigid3d& export_from_world,
                    const std::string& path);

}  // namespace surfit
