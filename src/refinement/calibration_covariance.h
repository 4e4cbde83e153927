#pragma once

#include <Eigen/Core>
#include <vector>

#include "refinement/reduced_system.h"

namespace surfit {

// Covariance of the calibration's ten numbers with poses and displacements free (the first pose and
// what of the calibration is held aside): the block of the inverse of the reduced hessian, for
// errors of unit variance. Rows and columns of held numbers are zero.
Eigen::MatrixXd CalibrationCovariance(const ReducedSystem& system,
                                      const std::vector<bool>& held_calibration);

}  // namespace surfit
