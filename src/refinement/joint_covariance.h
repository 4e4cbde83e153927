#pragma once

#include <Eigen/Core>
#include <vector>

#include "refinement/reduced_system.h"

namespace surfit {

// Covariances for errors of unit variance: blocks of the inverse of the reduced hessian, so that
// all else is free, but for the first pose and what of the calibration is held.
struct JointCovariance {
  Eigen::MatrixXd calibration;  // 10 x 10; rows and columns of held numbers are zero
  // Of each pose's increment (w [rad], v [m]), 6 x 6: zero of the first, infinite on the diagonal
  // of poses that share no surfel.
  std::vector<Eigen::MatrixXd> poses;
};

JointCovariance CovarianceOf(const ReducedSystem& system,
                             const std::vector<bool>& held_calibration);

}  // namespace surfit
