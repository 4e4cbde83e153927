#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "surfit/core/image.h"
#include "surfit/geometry/pinhole_camera.h"
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

// Image that the colours of Gaussians should reproduce.
struct GaussianView {
  Image<Rgb8> color;
  PinholeCamera camera;  // without distortion, with the size of `color`
  float dilation_px2;    // added to projected covariances
  Rigid3d world_from_camera;
};

// View of an image of `camera` without distortion, reduced to at most 320 columns. The renderers of
// 3D Gaussian splatting add 0.3 px^2 to the projected covariance.
GaussianView ReducedView(const Image<Rgb8>& color, PinholeCamera camera,
                         const Rigid3d& world_from_camera);

// Fits the colours of Gaussians to images. A pixel p blends splats from front to back with weights
// w_pj, before a black background. A step of SIRT (Gilbert 1972) is
//   c_j += sum_p w_pj (I_p - sum_k w_pk c_k) / sum_p w_pj.
// Pixels with more background than splats are ignored. Colours stay between 0 and 1. Calls
// `progress`, which must not be empty, with the number of drawn views, and the number of all. The
// result is bitwise identical for any number of threads.
void FitColors(const std::vector<GaussianView>& views,
               const std::function<void(int, int)>& progress, std::vector<Gaussian>* gaussians);

}  // namespace surfit
