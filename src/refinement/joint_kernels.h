#pragma once

#include <cmath>

#include "surfit/registration/error_model.h"

namespace surfit {

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
inline double InversePlaneSigma(const ErrorModel& model, double inverse_depth) {
  const double z = 1 / inverse_depth;  // sigma_(1/z) = sigma_z / z^2
  return z * z / model.Sigma(z);
}

// Of the differences of intensity, the weight included.
inline double InverseTextureSigma(const ErrorModel& model) {
  return std::sqrt(model.photometric_weight) / model.intensity_sigma;
}

}  // namespace surfit
