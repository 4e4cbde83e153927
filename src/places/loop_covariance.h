#pragma once

#include <Eigen/Core>

#include "surfit/registration/normal_system.h"

namespace surfit {

// The largest standard deviation in any direction.
double LargestSigma(const Eigen::Matrix3d& covariance);

// The left increment that the information holds least, of the length that moves points at that
// distance by about 1 m.
Vector6d WeakestIncrement(const Matrix6d& information, double distance_m);

// What a loop's covariance is in truth, from registration's and from how far registration the other
// way round disagrees. Registration's own is as if all residuals were independent, but neighbours
// share noise through filters; and both views share what is wrong with the camera's calibration,
// which many points do not make less.
Matrix6d LoopCovariance(const Matrix6d& covariance, double disagreement_rad, double disagreement_m);

// Its inverse, symmetric to the last bit.
Matrix6d InformationOf(const Matrix6d& covariance);

}  // namespace surfit
