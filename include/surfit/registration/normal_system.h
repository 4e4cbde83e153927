#pragma once

#include <Eigen/Core>

#include "surfit/registration/correspondences.h"

namespace surfit {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

// The linearised point-to-plane problem about the present pose, in the target's camera frame.
//
// With the left increment (w, v), p' = R p + t moves to exp(w) p' + v = p' + w x p' + v + O(w^2),
// so that the residual r = n . (p' - q) becomes
//   r(w, v) = n . (p' + w x p' + v - q) = a . (w, v) - b,
//   a = [p' x n, n] (a row of A),  b = n . (q - p'),
// because n . (w x p') = w . (p' x n). The least-squares increment solves A^T W A x = A^T W b.
// Units: w in rad, v in metres. Rotations turn about the target camera's centre, so that
// conditioning does not depend on where the world's origin lies.
struct NormalSystem {
  Matrix6d hessian = Matrix6d::Zero();     // A^T W A
  Vector6d right_side = Vector6d::Zero();  // A^T W b
  double weighted_square_sum = 0;          // sum of w r^2
  double weight_sum = 0;                   // sum of w
  double weighted_point_square_sum = 0;    // sum of w |p'|^2
  int pair_count = 0;                      // pairs that were associated
  int inlier_count = 0;  // those whose residual is within ErrorModel::kInlierSigmas

  NormalSystem& operator+=(const NormalSystem& other);

  // Weighted mean of r^2 in m^2; 0 without pairs.
  double AverageLoss() const { return weight_sum > 0 ? weighted_square_sum / weight_sum : 0; }

  // Root of the weighted mean of |p'|^2, in metres; 0 without pairs.
  double RmsDistance() const;

  // The eigenvalues, ascending, of A^T W A per weight after measuring rotations as arc lengths at
  // the points' RMS distance: without unit, from 0 (a direction the data does not hold) to 1.
  Vector6d ScaledEigenvalues() const;
};

// Sums the rows of all correspondences in double precision, in their order.
NormalSystem BuildNormalSystem(const Correspondences& correspondences);

}  // namespace surfit
