#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "cost_functions/plane_inverse_depth.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/optimization/refine.h"
#include "surfit/registration/error_model.h"

namespace surfit {

struct SharedSurfels;

// Parameters of the joint problem, except the surfel parameters.
struct JointState {
  std::vector<Rigid3d> world_from_camera;  // of the keyframes: depth camera, m
  DepthCalibration calibration;
};

// State with precomputed rotation matrices. Keeps a reference to the state, which must not
// change.
struct PlacedPoses {
  explicit PlacedPoses(const JointState& joint) : state(joint) {
    for (const Rigid3d& pose : joint.world_from_camera) {
      rotations.push_back(pose.rotation.toRotationMatrix());
    }
  }

  const JointState& state;
  std::vector<Eigen::Matrix3d> rotations;
};

// Parameter block of the calibration, of size kCalibrationSize. The image size is not included.
inline void CalibrationToBlock(const DepthCalibration& calibration, double* block) {
  const PinholeCamera& camera = calibration.camera;
  block[0] = camera.fx, block[1] = camera.fy, block[2] = camera.cx, block[3] = camera.cy;
  std::copy(calibration.field.coefficients.begin(), calibration.field.coefficients.end(),
            block + kFieldBegin);
  block[kReadout] = calibration.readout_s;
}

// Inverse of CalibrationToBlock(). Keeps the image size.
inline void CalibrationFromBlock(const double* block, DepthCalibration* calibration) {
  PinholeCamera& camera = calibration->camera;
  camera.fx = block[0], camera.fy = block[1], camera.cx = block[2], camera.cy = block[3];
  std::copy(block + kFieldBegin, block + kReadout, calibration->field.coefficients.begin());
  calibration->readout_s = block[kReadout];
}

// The photometric weight W scales the texture residuals and their kernel width k by sqrt(W). This
// multiplies the cost rho(s) of a squared residual s by W.
struct JointKernels {
  RobustKernel plane, texture;

  JointKernels Widened(double growth) const {
    JointKernels wide = *this;
    wide.plane.width *= growth;
    wide.texture.width *= growth;
    return wide;
  }
};

// Without photometric residuals, `texture` has no effect.
inline JointKernels KernelsOf(const ErrorModel& model) {
  JointKernels kernels = {model.kernel, model.intensity_kernel};
  if (model.UsesIntensities()) kernels.texture.width *= std::sqrt(model.photometric_weight);
  return kernels;
}

// 1 / sigma of the measured inverse depth, m. Requires inverse_depth > 0.
inline double InversePlaneSigma(const ErrorModel& model, const DepthNoise& noise,
                                double inverse_depth) {
  const double z = 1 / inverse_depth;  // sigma_(1/z) = sigma_z / z^2
  return z * z / model.Sigma(z, noise);
}

// 1 / sigma of intensity differences, including the photometric weight. 0 without photometric
// residuals.
inline double InverseTextureSigma(const ErrorModel& model) {
  return std::sqrt(model.photometric_weight) / model.intensity_sigma;
}

// Sums over observations, at the optimal surfel parameters.
struct JointFit {
  double rho = 0;             // sum of rho of all residuals: twice the cost
  double weight = 0;          // sum of the kernel weights rho' of plane residuals
  double squared_sigmas = 0;  // weighted sum of r^2 of plane residuals
  double squared_metres = 0;  // weighted sum of squared point-to-plane distances, m^2
  double texture_weight = 0;  // sum of the kernel weights rho' of texture residuals
  double squared_differences =
      0;  // weighted sum of squared intensity differences, without W and sigma

  JointFit& operator+=(const JointFit& other) {
    rho += other.rho;
    weight += other.weight;
    squared_sigmas += other.squared_sigmas;
    squared_metres += other.squared_metres;
    texture_weight += other.texture_weight;
    squared_differences += other.squared_differences;
    return *this;
  }
};

// Root mean squares of a fit. All are 0 without plane residuals of positive weight.
RefinementFit Agreement(const JointFit& fit);

// Variance factor: weighted mean square of the plane residuals, corrected for degrees of freedom
// and for the correlation of normals (`correlation_px`). 0 without redundant observations.
double VarianceOf(const JointFit& fit, const SharedSurfels& shared, const JointState& state,
                  const RefinementOptions& options);

// Diagonal covariance (11 x 11) of the model error, see RefinementOptions::model_error_ratio. 0 for
// fixed parameters: `held` has kCalibrationSize values.
Eigen::MatrixXd ModelErrorOf(const DepthCalibration& calibration, const std::vector<bool>& held,
                             const RefinementOptions& options);

// Squared Mahalanobis distance of `calibration` from `given`, over the `free` parameters: those
// with a positive variance.
struct CalibrationChange {
  double squared_distance = 0;
  int free = 0;

  // Mean plus `sigmas` standard deviations of the chi-square distribution with `free` degrees
  // of freedom.
  double Limit(double sigmas) const;
};
CalibrationChange ChangeOf(const DepthCalibration& calibration, const DepthCalibration& given,
                           const Eigen::MatrixXd& covariance);

}  // namespace surfit
