#include "surfit/registration/normal_system.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>

namespace surfit {

NormalSystem& NormalSystem::operator+=(const NormalSystem& other) {
  hessian += other.hessian;
  right_side += other.right_side;
  cost += other.cost;
  weighted_square_sum += other.weighted_square_sum;
  weight_sum += other.weight_sum;
  weighted_point_square_sum += other.weighted_point_square_sum;
  row_count += other.row_count;
  pair_count += other.pair_count;
  inlier_count += other.inlier_count;
  return *this;
}

double NormalSystem::RmsDistance() const {
  return weight_sum > 0 ? std::sqrt(weighted_point_square_sum / weight_sum) : 0;
}

double NormalSystem::VarianceFactor() const {
  return row_count > 6 ? weighted_square_sum / (row_count - 6) : 1;
}

Vector6d Observability::Held(const Vector6d& increment) const {
  Vector6d parts = coordinates * increment;
  parts.head(free_count).setZero();
  return directions * parts;
}

std::vector<Vector6d> Observability::FreeDirections() const {
  std::vector<Vector6d> free;
  for (int i = 0; i < free_count; ++i) free.emplace_back(directions.col(i));
  return free;
}

Observability Observe(const NormalSystem& system, double min_eigenvalue) {
  Observability result;
  if (!(system.RmsDistance() > 0)) return result;
  Vector6d length = Vector6d::Ones();  // of a unit of each component, in metres
  length.head<3>().setConstant(system.RmsDistance());
  const Vector6d inverse = length.cwiseInverse();
  const Matrix6d scaled =
      inverse.asDiagonal() * system.hessian * inverse.asDiagonal() / system.weight_sum;
  const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(scaled);
  result.eigenvalues = solver.eigenvalues();
  result.directions = inverse.asDiagonal() * solver.eigenvectors();
  result.coordinates = solver.eigenvectors().transpose() * length.asDiagonal();
  result.free_count = 0;
  while (result.free_count < 6 && !(result.eigenvalues[result.free_count] > min_eigenvalue)) {
    ++result.free_count;
  }
  return result;
}

Vector6d SolveHeld(const NormalSystem& system, const Observability& observability) {
  Vector6d parts = observability.directions.transpose() * system.right_side;
  for (int i = 0; i < 6; ++i) {
    const bool is_free = i < observability.free_count;
    parts[i] = is_free ? 0 : parts[i] / (observability.eigenvalues[i] * system.weight_sum);
  }
  return observability.directions * parts;
}

Matrix6d CovarianceOf(const NormalSystem& system) {
  return system.VarianceFactor() * system.hessian.ldlt().solve(Matrix6d::Identity());
}

}  // namespace surfit
