#pragma once

#include <optional>
#include <vector>

#include "surfit/core/robust_kernel.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/registration/association.h"
#include "surfit/registration/error_model.h"
#include "surfit/registration/normal_system.h"

namespace surfit {

// Scales of CovarianceOfClouds().
struct CloudErrorScales {
  double noise_m = 0;  // standard deviation of the residuals
  // Points in one cell have correlated errors. Cells are cubes of this size in m. With a camera of
  // the target, cells are square blocks of this size in px in its image.
  double cell = 0;
  const PinholeCamera* camera = nullptr;
};

// Covariance of a pose, or the directions (rad, m) that the clouds do not constrain.
struct CloudCovariance {
  std::optional<Matrix6d> covariance;
  // Left perturbation to the minimum of the cost: a Newton step. 0 without a covariance.
  Vector6d step_to_minimum = Vector6d::Zero();
  std::vector<Vector6d> degenerate_directions;

  // Length of the step to the minimum, in standard deviations. 0 without a covariance.
  double StepSigmas() const;
};

// Covariance of the pose that minimises the cost of the clouds, for the left perturbation (rad, m).
// This is the sandwich estimator (Huber 1967; White 1980; for cells: Liang and Zeger 1986)
//   C = J^-1 B J^-T,  B = sum over the cells c of h_c h_c^T,
// with h_c the gradient of the points in cell c, corrected by the jackknife (Bell and McCaffrey
// 2002). B contains the noise of points and normals, and errors that points in a cell share. J is
// the derivative of the gradient. It is numerical, with new correspondences at each pose. So J is
// small along directions in which the correspondences move with the pose, and does not contain
// information from noise of normals.
//
// Directions in which J is at most 3e-4 of its largest eigenvalue are degenerate. They are tested
// over the extent of the noise too, because a local slope of noise is no constraint. There is no
// covariance with degenerate directions, with fewer than 12 cells, or without correspondences.
CloudCovariance CovarianceOfClouds(const Association& association,
                                   const Rigid3d& target_from_source, ResidualType residual,
                                   const RobustKernel& kernel, const CloudErrorScales& scales);

}  // namespace surfit
