#pragma once

#include "surfit/registration/normal_system.h"

namespace surfit {

// What a loop's covariance is in truth, from registration's and from how far registration the other
// way round disagrees. Registration's own is as if all residuals were independent, but neighbours
// share noise through filters; and both views share what is wrong with the camera's calibration,
// which many points do not make less.
Matrix6d LoopCovariance(const Matrix6d& covariance, double disagreement_rad, double disagreement_m);

}  // namespace surfit
