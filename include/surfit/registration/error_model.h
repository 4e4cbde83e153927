#pragma once

#include <cmath>

#include "surfit/frame/depth_noise.h"

namespace surfit {

// The one error model of registration. A point-to-plane residual r = n . (p' - q) in metres has
//   sigma^2 = floor_sigma_m^2 + sigma_z(z)^2,
// z the measured depth of the source point: the sensor's noise on top of what the map, the normals
// and the calibration leave over. Its weight is 1 / sigma^2, times the robust kernel's
// rho'(s) = 1 / (1 + s / k^2)^2 (Geman and McClure), s = (r / sigma)^2, in iteratively reweighted
// least squares.
struct ErrorModel {
  // A pair is an inlier if its residual is within so many sigmas.
  static constexpr double kInlierSigmas = 3;

  DepthNoise noise;
  double floor_sigma_m = 0.004;
  double kernel_width = 3;  // k, in sigmas; 0 = no robust kernel

  // Throws InputError naming field, value and constraint.
  void Validate() const;

  // Standard deviation in metres of the residual of a point at this depth.
  double Sigma(double depth_m) const {
    const double sigma_z = noise.SigmaZ(depth_m);
    return std::sqrt(floor_sigma_m * floor_sigma_m + sigma_z * sigma_z);
  }
};

}  // namespace surfit
