#pragma once

#include "surfit/registration/normal_system.h"

namespace surfit {

// Decompositions of matrices of fixed size, compiled once: each of Eigen's costs seconds.

// The solution x of matrix * x = right_side, for symmetric matrices.
Vector6d SolveLdlt(const Matrix6d& matrix, const Vector6d& right_side);
Eigen::Vector3d SolveLdlt3(const Eigen::Matrix3d& matrix, const Eigen::Vector3d& right_side);
// The same by LU decomposition.
Vector6d SolveLu(const Matrix6d& matrix, const Vector6d& right_side);

// The inverse of a symmetric matrix: by LDLT, and by LU, symmetric to the last bit.
Matrix6d InverseByLdlt(const Matrix6d& matrix);
Matrix6d SymmetricInverse(const Matrix6d& matrix);

// Ascending, of a symmetric matrix.
Vector6d EigenvaluesOf(const Matrix6d& matrix);

// Columns x with matrix x = mu metric x, mu ascending, both symmetric, the metric positive.
struct GeneralizedEigen {
  Vector6d values;
  Matrix6d vectors;
};
GeneralizedEigen EigenOf(const Matrix6d& matrix, const Matrix6d& metric);

// The left increment that the information holds least, of the length that moves points at that
// distance by about 1 m.
Vector6d WeakestIncrement(const Matrix6d& information, double distance_m);

// The largest standard deviation in any direction.
double LargestSigma(const Eigen::Matrix3d& covariance);

// The rotation nearest to the matrix: U diag(1, 1, det(U V^T)) V^T, without the last sign a
// reflection where the points are nearly on a plane or noise prevails.
Eigen::Matrix3d NearestRotation(const Eigen::Matrix3d& matrix);

}  // namespace surfit
