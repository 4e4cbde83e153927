#include "surfit/registration/normal_system.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "registration/solvers/decompositions.h"
#include "surfit/geometry/rigid3.h"

namespace surfit {
namespace {

// Scales information matrices so that they have no unit. See Observability.
struct UnitFree {
  explicit UnitFree(const NormalSystem& system) : weight_sum(system.weight_sum) {
    length.head<3>().setConstant(system.RmsDistance());
  }
  Matrix6d operator()(const Matrix6d& information) const {
    const Vector6d inverse = length.cwiseInverse();
    return inverse.asDiagonal() * information * inverse.asDiagonal() / weight_sum;
  }

  Vector6d length = Vector6d::Ones();  // m per rad for rotations, 1 for translations
  double weight_sum;
};

}  // namespace

PhotometricSystem& PhotometricSystem::operator+=(const PhotometricSystem& other) {
  hessian += other.hessian;
  right_side += other.right_side;
  cost += other.cost;
  square_sum += other.square_sum;
  row_count += other.row_count;
  return *this;
}

NormalSystem& NormalSystem::operator+=(const NormalSystem& other) {
  hessian += other.hessian;
  right_side += other.right_side;
  cost += other.cost;
  weighted_square_sum += other.weighted_square_sum;
  weight_sum += other.weight_sum;
  normal_difference_sum += other.normal_difference_sum;
  normal_ratio = std::max(normal_ratio, other.normal_ratio);
  point_sum += other.point_sum;
  point_product_sum += other.point_product_sum;
  row_count += other.row_count;
  pair_count += other.pair_count;
  inlier_count += other.inlier_count;
  photometric += other.photometric;
  return *this;
}

void NormalSystem::Add(const PhotometricSystem& intensities) {
  hessian += intensities.hessian;
  right_side += intensities.right_side;
  photometric += intensities;
}

double NormalSystem::RmsDistance() const {
  return weight_sum > 0 ? std::sqrt(point_product_sum.trace() / weight_sum) : 0;
}

Matrix6d NormalSystem::SpuriousInformation() const {
  if (!(weight_sum > 0)) return Matrix6d::Zero();
  Matrix6d all;  // sum of w G^T G; G = [-[p]x, I]: derivative of the moved point p
  all.topLeftCorner<3, 3>() =
      point_product_sum.trace() * Eigen::Matrix3d::Identity() - point_product_sum;
  all.topRightCorner<3, 3>() = CrossMatrix<double>(point_sum);
  all.bottomLeftCorner<3, 3>() = -CrossMatrix<double>(point_sum);
  all.bottomRightCorner<3, 3>() = weight_sum * Eigen::Matrix3d::Identity();
  const double difference = normal_difference_sum / weight_sum;
  return normal_ratio * difference * difference / M_PI * (all - (hessian - photometric.hessian));
}

double NormalSystem::VarianceFactor() const {
  return row_count > 6 ? weighted_square_sum / (row_count - 6) : 1;
}

Vector6d Observability::Held(const Vector6d& increment) const {
  Vector6d parts = coordinates * increment;
  parts.head(degenerate_count).setZero();
  return directions * parts;
}

std::vector<Vector6d> Observability::DegenerateDirections() const {
  std::vector<Vector6d> free;
  for (int i = 0; i < degenerate_count; ++i) free.emplace_back(directions.col(i));
  return free;
}

Observability Observe(const NormalSystem& system, const ObservabilityOptions& options) {
  Observability result;
  if (!(system.RmsDistance() > 0)) return result;
  const UnitFree unit_free(system);
  const Matrix6d hessian = unit_free(system.hessian);
  const std::optional<Vector6d> eigenvalues = EigenvaluesOf(hessian);
  // Directions x with H x = mu B x diagonalise both matrices. x^T H x > x^T B x for mu > 1.
  constexpr double kRounding = 1e-15;
  const Matrix6d needed = std::max(options.min_eigenvalue, kRounding) * Matrix6d::Identity() +
                          options.min_information_ratio * unit_free(system.SpuriousInformation());
  const std::optional<GeneralizedEigen> eigen = EigenOf(hessian, needed);
  if (!eigenvalues || !eigen) return result;
  result.eigenvalues = *eigenvalues;
  const Vector6d norms = eigen->vectors.colwise().norm();
  result.directions = unit_free.length.cwiseInverse().asDiagonal() * eigen->vectors *
                      norms.cwiseInverse().asDiagonal();
  result.coordinates =
      norms.asDiagonal() * eigen->vectors.transpose() * needed * unit_free.length.asDiagonal();
  result.degenerate_count = 0;
  while (result.degenerate_count < 6 && !(eigen->values[result.degenerate_count] > 1))
    ++result.degenerate_count;
  return result;
}

Vector6d SolveObservable(const NormalSystem& system, const Observability& observability) {
  Vector6d increment = Vector6d::Zero();
  for (int i = observability.degenerate_count; i < 6; ++i) {
    const Vector6d direction = observability.directions.col(i);
    increment +=
        direction.dot(system.right_side) / direction.dot(system.hessian * direction) * direction;
  }
  return increment;
}

Matrix6d ConservativeInformation(const NormalSystem& system, double photometric_ratio) {
  if (!(system.RmsDistance() > 0)) return Matrix6d::Zero();
  constexpr double kSmallest = 1e-9;  // relative error of single-precision sums
  const UnitFree unit_free(system);
  const Matrix6d metric =
      kSmallest * Matrix6d::Identity() + unit_free(system.SpuriousInformation());
  const std::optional<GeneralizedEigen> eigen =
      EigenOf(unit_free(system.hessian - system.photometric.hessian), metric);
  if (!eigen) return Matrix6d::Zero();
  // With the columns X of the eigenvectors, X^T B X = I and H = (B X) mu (B X)^T.
  const Matrix6d columns = unit_free.length.asDiagonal() * metric * eigen->vectors;
  const Vector6d trusted = (eigen->values.array() - 1).max(0);
  const Matrix6d of_points =
      system.weight_sum * (columns * trusted.asDiagonal() * columns.transpose());
  const Matrix6d sum = of_points + photometric_ratio * system.photometric.hessian;
  constexpr double kSmallestVariance = 1e-3;  // residuals can be far below the sensor noise
  return (0.5 / (kSharedPoints * std::max(system.VarianceFactor(), kSmallestVariance))) *
         (sum + sum.transpose());
}

Matrix6d CovarianceOf(const NormalSystem& system) {
  return system.VarianceFactor() * InverseByLdlt(system.hessian);
}

}  // namespace surfit
