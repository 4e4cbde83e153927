#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "surfit/core/robust_kernel.h"
#include "surfit/geometry/sensor.h"

namespace surfit {

// Residual types, for a source point p' = R p + t with unit normal m and its target point q with
// unit normal n. Residuals are in m, and have the weight 1 / sigma^2. RegisterResidual() adds
// further values.
enum class ResidualType {
  kPointToPoint,           // p' - q (Besl and McKay 1992)
  kPointToPlane,           // n . (p' - q) (Chen and Medioni 1992)
  kSymmetricPointToPlane,  // (n + m) / 2 . (p' - q) (Rusinkiewicz 2019)
  kPlaneToPlane,           // U (p' - q), U^T U = C^-1, C of both planes (Segal et al. 2009, GICP)
};

// "point_to_point", "point_to_plane", "symmetric_point_to_plane", "plane_to_plane", and the names
// of RegisterResidual().
std::vector<std::string> ResidualTypeNames();
// Throws InputError with all valid names for an unknown name.
ResidualType ResidualTypeFromName(const std::string& name);
std::string ToString(ResidualType type);

// Normals that a correspondence must have.
enum class NeededNormals { kNone, kTarget, kBoth };
NeededNormals NormalsNeededBy(ResidualType type);

class OptionVisitor;

// Error model of registration. A residual r in m (ResidualType) has the variance
//   sigma^2 = floor_sigma_m^2 + sigma_z(z)^2,
// with the measured depth z of the source point. sigma_z is the sensor noise of its level.
// floor_sigma_m covers errors of map, normals and calibration. With s = |r|^2 / sigma^2, the cost
// is
//   1/2 sum rho(s).
// The solvers closed_form_* and svd use iteratively reweighted least squares with the weights
// rho'(s) / sigma^2. The other solvers use Levenberg-Marquardt.
//
// With a photometric weight W > 0, and if both views have intensities, the cost is
//   1/2 sum rho(s) + W/2 sum rho_I(s_I),  s_I = r_I^2 / intensity_sigma^2.
// r_I is the difference of the intensities of a point in both views, after compensation of the
// exposure.
struct ErrorModel {
  // Correspondences with a residual of at most this many sigmas are inliers.
  static constexpr double kInlierSigmas = 3;

  double floor_sigma_m = 0.004;
  RobustKernel kernel = {RobustKernelType::kGemanMcClure, 3};

  // W; 0: geometric residuals only. Errors of neighbouring pixels are correlated, mainly through
  // the map colours, so W must be far below 1. With 0.01, tracking succeeds along textured walls,
  // and well constrained poses hardly change.
  double photometric_weight = 0;
  double intensity_sigma = 0.02;  // of r_I, for intensities from 0 to 1
  RobustKernel intensity_kernel = {RobustKernelType::kHuber, 1.5};

  bool UsesIntensities() const { return photometric_weight > 0; }

  // Ratio of the photometric information that is trusted, because neighbouring pixels have
  // correlated errors. It corresponds to a weight of at most 0.003. With a third of this weight the
  // motion prior dominates in front of textured floors. With three times this weight, shading on
  // bare walls pulls the pose.
  double TrustedPhotometricRatio() const {
    constexpr double kTrustedWeight = 0.003;
    return photometric_weight > kTrustedWeight ? kTrustedWeight / photometric_weight : 1;
  }

  void Visit(OptionVisitor& visitor);

  // Standard deviation in m of the residual of a point with this measured depth in m.
  double Sigma(double depth_m, const DepthNoise& noise) const {
    const double sigma_z = noise.SigmaZ(depth_m);
    return std::sqrt(floor_sigma_m * floor_sigma_m + sigma_z * sigma_z);
  }
};

}  // namespace surfit
