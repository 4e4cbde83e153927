#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "surfit/core/robust_kernel.h"
#include "surfit/geometry/sensor.h"

namespace surfit {

// What registration makes small, for a source point p' = R p + t with the unit normal m and its
// target point q with the unit normal n. All are lengths in metres, weighted by 1 / sigma^2.
// Residuals of one's own have values beyond these: see RegisterResidual().
enum class ResidualType {
  kPointToPoint,           // p' - q (Besl and McKay 1992)
  kPointToPlane,           // n . (p' - q) (Chen and Medioni 1992)
  kSymmetricPointToPlane,  // (n + m) / 2 . (p' - q) (Rusinkiewicz 2019)
  kPlaneToPlane,           // U (p' - q), U^T U = C^-1, C of two planes (Segal et al. 2009, GICP)
};

// "point_to_point", "point_to_plane", "symmetric_point_to_plane", "plane_to_plane", and what was
// registered.
std::vector<std::string> ResidualTypeNames();
// Throws InputError that lists the names for an unknown one.
ResidualType ResidualTypeFromName(const std::string& name);
std::string ToString(ResidualType type);

// Which normals a pair must have.
enum class NeededNormals { kNone, kTarget, kBoth };
NeededNormals NormalsNeededBy(ResidualType type);

class OptionVisitor;

// The one error model of registration. A residual r in metres (ResidualType) has
//   sigma^2 = floor_sigma_m^2 + sigma_z(z)^2,
// z the measured depth of the source point and its level's noise: the sensor's noise on top of what
// the map, the normals and the calibration leave over. With s = |r|^2 / sigma^2, registration
// minimises
//   1/2 sum rho(s):
// the closed form by rows weighted with rho'(s) / sigma^2 and computed anew in each step
// (iteratively reweighted least squares), Levenberg-Marquardt within its solve.
//
// With a photometric weight W > 0, and where both views have intensities, it minimises
//   1/2 sum rho(s) + W/2 sum rho_I(s_I),  s_I = r_I^2 / intensity_sigma^2,
// r_I the difference of the intensities that a point has in both views (PhotometricTerm).
struct ErrorModel {
  // A pair is an inlier if its residual is within so many sigmas.
  static constexpr double kInlierSigmas = 3;

  double floor_sigma_m = 0.004;
  RobustKernel kernel = {RobustKernelType::kGemanMcClure, 3};
  // Whether the kernel's width is measured in sigmas of the model, or in those estimated before
  // each solve from the residuals: the median of |r| / sigma over that of its distribution for
  // normal errors (0.6745 for one component, 1.5382 for three).
  bool estimate_scale = false;

  // W; 0 = off. Neighbouring pixels share most of their errors, those of a map's colours above all,
  // so that 1, as if they did not, is far too much. 0.01 tracks along textured walls, and hardly
  // moves what shapes hold.
  double photometric_weight = 0;
  double intensity_sigma = 0.02;  // of r_I, of intensities from 0 to 1
  RobustKernel intensity_kernel = {RobustKernelType::kHuber, 1.5};

  bool UsesIntensities() const { return photometric_weight > 0; }

  // So much of what intensities say with that weight can be trusted, given how many share their
  // errors. With a third of it a camera before textured floors is led astray by what it did before,
  // with three times as much by shades of bare walls.
  double TrustedPhotometricShare() const {
    constexpr double kTrustedWeight = 0.003;
    return photometric_weight > kTrustedWeight ? kTrustedWeight / photometric_weight : 1;
  }

  void Visit(OptionVisitor& visitor);

  // Standard deviation in metres of the residual of a point that such a sensor measures at this
  // depth.
  double Sigma(double depth_m, const DepthNoise& noise) const {
    const double sigma_z = noise.SigmaZ(depth_m);
    return std::sqrt(floor_sigma_m * floor_sigma_m + sigma_z * sigma_z);
  }
};

}  // namespace surfit
