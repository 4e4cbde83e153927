#pragma once

#include <Eigen/Core>

#include "optimization/refinement/joint_state.h"
#include "optimization/refinement/shared_surfels.h"

namespace surfit {

// Cluster-robust "sandwich" covariance of the calibration. It does not assume independent errors
// (Liang and Zeger, "Longitudinal data analysis using generalized linear models", Biometrika 1986).
// Neighbouring surfels of a surface share errors of the sensor, for example of smoothed or
// completed depth. The sum of their gradients g moves the calibration by d = influence g, and the
// covariance is
//   G / (G - 1) sum(d d^T) over G clusters.
// `influence` has the calibration rows of the inverse Hessian, 11 x (6 poses + 11). Clusters are
// the cells of a grid in the image of the first keyframe that observes a surfel. Returns 0 for
// fewer than two clusters. The result is the same for any number of threads.
Eigen::MatrixXd ClusteredCovariance(const SharedSurfels& shared, const JointState& state,
                                    const JointKernels& kernels, const Eigen::MatrixXd& influence);

// Mean ratio of a clustered variance to the variance by the error model, over all directions of the
// calibration: the mean eigenvalue of covariance^-1 clustered. Divide a squared distance by this
// ratio before comparing it with a chi-square distribution. Source: Rao and Scott, "The Analysis of
// Categorical Data From Complex Sample Surveys", JASA 1981. At least 1. Both matrices are 11 x 11
// and 0 for fixed parameters.
double ClusterEffect(const Eigen::MatrixXd& covariance, const Eigen::MatrixXd& clustered);

}  // namespace surfit
