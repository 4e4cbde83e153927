#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "surfit/geometry/rigid3.h"
#include "surfit/mapping/surfel_block.h"

namespace surfit {

// Flat Gaussian. The standard deviation along the normal is kFlatness times `sigma_m`. The opacity
// is kGaussianOpacity.
struct Gaussian {
  Eigen::Vector3f position_m, normal;  // in the world frame
  float sigma_m = 0;                   // tangential standard deviation
  Eigen::Vector3f color;               // 0 to 1
};

constexpr float kFlatness = 0.05f;
// Renderers blend splats from front to back, without regard to surfaces. The background shines
// through fainter Gaussians.
constexpr float kGaussianOpacity = 0.95f;

// One Gaussian per surfel, with its colour. The standard deviation is a fixed ratio of the distance
// to the sixth neighbour, or of four times the radius if that is less. Positions must be finite.
std::vector<Gaussian> GaussiansOf(const std::vector<Surfel>& surfels);

// Writes Gaussians in the PLY format of 3D Gaussian splatting (Kerbl et al., SIGGRAPH 2023).
// Properties: x y z, nx ny nz, f_dc_0..2, f_rest_0..44 (0), opacity (logit), scale_0..2, rot_0..3
// (w first). A scale is the logarithm of a standard deviation in m. The third axis is the normal.
// Throws InputError with the path if writing fails.
void WriteGaussians(const std::vector<Gaussian>& gaussians, const Rigid3d& export_from_world,
                    const std::string& path);

}  // namespace surfit
