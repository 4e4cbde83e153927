#pragma once

#include "surfit/registration/normal_system.h"

namespace surfit {

// The covariance of an increment (w, v) whose components are independent.
inline Matrix6d Variances(double sigma_rad, double sigma_m) {
  Vector6d sigmas;
  sigmas << Eigen::Vector3d::Constant(sigma_rad), Eigen::Vector3d::Constant(sigma_m);
  return sigmas.cwiseAbs2().asDiagonal();
}

}  // namespace surfit
