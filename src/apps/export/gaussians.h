#pragma once

#include <string>
#include <vector>

#include "surfit/geometry/rigid3.h"
#include "surfit/mapping/surfel_block.h"

namespace surfit {

// Writes surfels as flat Gaussians in the PLY format of 3D Gaussian splatting (Kerbl, Kopanas,
// Leimkuehler and Drettakis, SIGGRAPH 2023): x y z, nx ny nz, f_dc_0..2, f_rest_0..44 (0), opacity
// (logit), scale_0..2 (logarithm of the standard deviation in m) and rot_0..3 (w first). The third
// axis is the normal. Throws InputError with the path if writing fails.
//
// Renderers blend the splats from front to back by their opacity, without regard to surfaces. So
// the opacity is high, and the standard deviation is a fixed ratio of the surfel radius.
void WriteGaussians(const std::vector<Surfel>& surfels, const Rigid3d& export_from_world,
                    const std::string& path);

}  // namespace surfit
