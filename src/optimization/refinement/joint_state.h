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

// What is to be found, but for the surfels' own numbers.
struct JointState {
  std::vector<Rigid3d> world_from_camera;
  DepthCalibration calibration;
};

// Poses as the rows use them. The state must outlive it.
struct PlacedPoses {
  explicit PlacedPoses(const JointState& joint) : state(joint) {
    for (const Rigid3d& pose : joint.world_from_camera) {
      rotations.push_back(pose.rotation.toRotationMatrix());
    }
  }

  const JointState& state;
  std::vector<Eigen::Matrix3d> rotations;
};

// The calibration as parameter block of kCalibrationSize; the size of the image is left as it is.
inline void CalibrationToBlock(const DepthCalibration& calibration, double* block) {
  const PinholeCamera& camera = calibration.camera;
  block[0] = camera.fx, block[1] = camera.fy, block[2] = camera.cx, block[3] = camera.cy;
  std::copy(calibration.field.coefficients.begin(), calibration.field.coefficients.end(),
            block + kFieldBegin);
  block[kReadout] = calibration.readout_s;
}

inline void CalibrationFromBlock(const double* block, DepthCalibration* calibration) {
  PinholeCamera& camera = calibration->camera;
  camera.fx = block[0], camera.fy = block[1], camera.cx = block[2], camera.cy = block[3];
  std::copy(block + kFieldBegin, block + kReadout, calibration->field.coefficients.begin());
  calibration->readout_s = block[kReadout];
}

// The robust kernels of all residuals. Those of texture have the photometric weight W in their
// standard deviation: all kernels are of the form rho(s) = k^2 f(s / k^2), so that W rho(s) is
// rho(W s) of the width k sqrt(W).
struct JointKernels {
  RobustKernel plane, texture;

  JointKernels Widened(double growth) const {
    JointKernels wide = *this;
    wide.plane.width *= growth;
    wide.texture.width *= growth;
    return wide;
  }
};

inline JointKernels KernelsOf(const ErrorModel& model) {
  JointKernels kernels = {model.kernel, model.intensity_kernel};
  if (model.UsesIntensities()) kernels.texture.width *= std::sqrt(model.photometric_weight);
  return kernels;
}

// 1 / sigma of inverse depth where that is measured, m.
inline double InversePlaneSigma(const ErrorModel& model, const DepthNoise& noise,
                                double inverse_depth) {
  const double z = 1 / inverse_depth;  // sigma_(1/z) = sigma_z / z^2
  return z * z / model.Sigma(z, noise);
}

// Of the differences of intensity, the weight included.
inline double InverseTextureSigma(const ErrorModel& model) {
  return std::sqrt(model.photometric_weight) / model.intensity_sigma;
}

// How far observations are from the surfels at their best numbers.
struct JointFit {
  double rho = 0;                  // the sum: twice the cost
  double weight = 0;               // the sum of rho' of planes
  double squared_sigmas = 0;       // the sums, so weighted, of r^2
  double squared_metres = 0;       // and of the squared distances of points to planes
  double texture_weight = 0;       // the sum of rho' of differences of intensity
  double squared_differences = 0;  // the sum, so weighted, of their squared errors

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

RefinementFit Agreement(const JointFit& fit);

// What the residuals of planes show an observation's variance to be, in the model's: their weighted
// mean square, for as many as they are more than what they determine; and more by as many as share
// the errors of their normals. 0 if they determine nothing.
double VarianceOf(const JointFit& fit, const SharedSurfels& shared, const JointState& state,
                  const RefinementOptions& options);

// The covariance that RefinementOptions::model_error_share stands for, 11 x 11 and diagonal: zero
// of what is held.
Eigen::MatrixXd ModelErrorOf(const DepthCalibration& calibration, const std::vector<bool>& held,
                             const RefinementOptions& options);

// The squared distance of a calibration from another by its covariance (11 x 11, zero of what was
// held), and the number of those that were free.
struct CalibrationChange {
  double squared_distance = 0;
  int free = 0;

  // Mean and variance of the squared distance, were the other the true one: as many as are free,
  // and twice as many.
  double Limit(double sigmas) const;
};
CalibrationChange ChangeOf(const DepthCalibration& calibration, const DepthCalibration& given,
                           const Eigen::MatrixXd& covariance);

}  // namespace surfit
