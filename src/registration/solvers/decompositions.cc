#include "registration/solvers/decompositions.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>

namespace surfit {

Vector6d SolveLdlt(const Matrix6d& matrix, const Vector6d& right_side) {
  return matrix.ldlt().solve(right_side);
}

Vector6d SolveLu(const Matrix6d& matrix, const Vector6d& right_side) {
  return matrix.partialPivLu().solve(right_side);
}

Matrix6d InverseByLdlt(const Matrix6d& matrix) { return matrix.ldlt().solve(Matrix6d::Identity()); }

Matrix6d SymmetricInverse(const Matrix6d& matrix) {
  const Matrix6d inverse = matrix.inverse();
  return (inverse + inverse.transpose()) / 2;
}

std::optional<Vector6d> EigenvaluesOf(const Matrix6d& matrix) {
  const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(matrix, Eigen::EigenvaluesOnly);
  if (solver.info() != Eigen::Success) return std::nullopt;
  return solver.eigenvalues();
}

std::optional<GeneralizedEigen> EigenOf(const Matrix6d& matrix, const Matrix6d& metric) {
  // The solver does not report a failure of its Cholesky decomposition.
  if (metric.llt().info() != Eigen::Success) return std::nullopt;
  const Eigen::GeneralizedSelfAdjointEigenSolver<Matrix6d> solver(matrix, metric);
  if (solver.info() != Eigen::Success) return std::nullopt;
  return GeneralizedEigen{solver.eigenvalues(), solver.eigenvectors()};
}

std::optional<Vector6d> WeakestIncrement(const Matrix6d& information, double distance_m) {
  Matrix6d scaled = information;
  scaled.topRows<3>() /= distance_m;
  scaled.leftCols<3>() /= distance_m;
  const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(scaled);
  if (solver.info() != Eigen::Success) return std::nullopt;
  Vector6d increment = solver.eigenvectors().col(0);
  increment.head<3>() /= distance_m;
  return increment;
}

double LargestSigma(const Eigen::Matrix3d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(covariance, Eigen::EigenvaluesOnly);
  if (eigen.info() != Eigen::Success) return std::numeric_limits<double>::infinity();
  return std::sqrt(std::max(0., eigen.eigenvalues()[2]));
}

Eigen::Matrix3d NearestRotation(const Eigen::Matrix3d& matrix) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return svd.matrixU() * Eigen::Vector3d(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
}

}  // namespace surfit
