#pragma once

#include <optional>

#include "surfit/registration/normal_system.h"

namespace surfit {

// Decompositions of fixed-size matrices, compiled once because Eigen's templates take seconds to
// compile. No function tests for singular matrices; their results are then not finite or arbitrary.

// Solves matrix * x = right_side for a symmetric matrix by LDLT.
Vector6d SolveLdlt(const Matrix6d& matrix, const Vector6d& right_side);
Vector6d SolveLu(const Matrix6d& matrix, const Vector6d& right_side);

// Require a symmetric matrix. The result of SymmetricInverse() is exactly symmetric.
Matrix6d InverseByLdlt(const Matrix6d& matrix);
Matrix6d SymmetricInverse(const Matrix6d& matrix);

// Eigenvalues of a symmetric matrix in ascending order. std::nullopt for a matrix that is not
// finite.
std::optional<Vector6d> EigenvaluesOf(const Matrix6d& matrix);

// Solutions of matrix x = mu metric x in ascending order of mu. Both matrices are symmetric.
struct GeneralizedEigen {
  Vector6d values;   // mu
  Matrix6d vectors;  // columns x, with x^T metric x = 1
};
// Returns std::nullopt if a matrix is not finite, or if the metric is not positive definite.
std::optional<GeneralizedEigen> EigenOf(const Matrix6d& matrix, const Matrix6d& metric);

// Left increment (rad, m) along the weakest direction of the information. It moves points at
// `distance_m` by about 1 m. std::nullopt if the information is not finite.
std::optional<Vector6d> WeakestIncrement(const Matrix6d& information, double distance_m);

// Largest standard deviation in any direction, in the unit of the covariance's square root.
// Infinite if the covariance is not finite.
double LargestSigma(const Eigen::Matrix3d& covariance);

// Rotation nearest to the matrix: U diag(1, 1, det(U V^T)) V^T. The sign prevents a reflection for
// nearly planar or noisy points.
Eigen::Matrix3d NearestRotation(const Eigen::Matrix3d& matrix);

}  // namespace surfit
