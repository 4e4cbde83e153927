#pragma once

#include <vector>

#include "refinement/reduced_system.h"

namespace surfit {

RefinementFit Agreement(const JointFit& fit);

// What the residuals of planes show an observation's variance to be, in the model's: their weighted
// mean square, for as many as they are more than what they determine; and more by as many as share
// the errors of their normals. 0 if they determine nothing.
double VarianceOf(const JointFit& fit, const SharedSurfels& shared, const JointState& state,
                  const RefinementOptions& options);

// The covariance that RefinementOptions::model_error_share stands for, 10 x 10 and diagonal: zero
// of what is held.
Eigen::MatrixXd ModelErrorOf(const DepthCalibration& calibration, const std::vector<bool>& held,
                             const RefinementOptions& options);

// The squared distance of a calibration from another by its covariance (10 x 10, zero of what was
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
