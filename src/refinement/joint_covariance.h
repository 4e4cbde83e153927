#pragma once

#include <vector>

#include "refinement/reduced_factor.h"

namespace surfit {

// Directions that nothing in the residuals tells have a variance about 1e12 times that which
// their own rows alone would give.
JointCovariance CovarianceOf(const ReducedSystem& system,
                             const std::vector<bool>& held_calibration);

}  // namespace surfit
