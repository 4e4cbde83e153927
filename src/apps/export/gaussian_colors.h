#pragma once

#include <functional>
#include <vector>

#include "apps/export/gaussians.h"
#include "surfit/core/image.h"
#include "surfit/geometry/pinhole_camera.h"
#include "surfit/geometry/rigid3.h"

namespace surfit {

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
