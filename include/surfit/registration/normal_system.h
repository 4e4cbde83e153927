#pragma once

#include <Eigen/Core>
#include <vector>

namespace surfit {

class OptionVisitor;

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

// What intensities add to a NormalSystem, weighted by ErrorModel::photometric_weight.
struct PhotometricSystem {
  Matrix6d hessian = Matrix6d::Zero();
  Vector6d right_side = Vector6d::Zero();
  double cost = 0;        // 1/2 sum of W rho_I(s_I)
  double square_sum = 0;  // sum of w r_I^2, in units of sigma^2
  int row_count = 0;

  PhotometricSystem& operator+=(const PhotometricSystem& other);
};

// The problem linearised about the present pose, in the target's frame, for the left increment
// (w, v) [rad, m] by which p' moves to exp(w) p' + v = p' + w x p' + v + O(w^2). Each residual has
// rows a with r(w, v) = a . (w, v) + r: see the ResidualType's derivation in residual_rows.h. The
// least-squares increment solves A^T W A x = -A^T W r. Rotations turn about the target camera's
// centre, so that conditioning does not depend on where the world's origin lies.
struct NormalSystem {
  Matrix6d hessian = Matrix6d::Zero();     // A^T W A
  Vector6d right_side = Vector6d::Zero();  // -A^T W r
  double cost = 0;                         // 1/2 sum of rho(s): see ErrorModel
  double weighted_square_sum = 0;          // sum of w |r|^2
  double weight_sum = 0;                   // sum of w
  double normal_difference_sum = 0;        // sum of w |m - n|
  double normal_share = 0;                 // of a normal's variance in the rows' direction
  Eigen::Vector3d point_sum = Eigen::Vector3d::Zero();          // sum of w p'
  Eigen::Matrix3d point_product_sum = Eigen::Matrix3d::Zero();  // sum of w p' p'^T
  int row_count = 0;     // residuals: pairs times their components
  int pair_count = 0;    // pairs that were associated
  int inlier_count = 0;  // those whose residual is within ErrorModel::kInlierSigmas

  // What hessian and right_side hold besides; all else is of the pairs of points alone.
  PhotometricSystem photometric;

  NormalSystem& operator+=(const NormalSystem& other);
  void Add(const PhotometricSystem& intensities);

  // Weighted mean of |r|^2 in m^2; 0 without pairs.
  double AverageLoss() const { return weight_sum > 0 ? weighted_square_sum / weight_sum : 0; }

  // The same of all that is minimised, intensities as multiples of their sigma. A pose that these
  // improve may fit the points less well: this tells whether registration comes nearer to its end.
  double JointLoss() const {
    return weight_sum > 0 ? (weighted_square_sum + photometric.square_sum) / weight_sum : 0;
  }
  double JointCost() const { return cost + photometric.cost; }

  // Root of the weighted mean of |p'|^2, in metres; 0 without pairs.
  double RmsDistance() const;

  // What noise of the normals adds to the Hessian. With G = [-[p']x | I], a row is a = n G. An
  // error of n by variance s^2 in both directions across it adds s^2 (G^T G - a^T a) on average: it
  // seems to hold what the surface itself leaves free. The two normals of a pair are estimates of
  // one, so that with normal errors the mean of |m - n| is s sqrt(pi), where both are equally
  // noisy; the mean of the squares would follow the few pairs whose surfaces differ.
  Matrix6d FeignedInformation() const;

  // Variance of the residuals in units of their sigma^2: sum of w |r|^2 per degree of freedom; 1
  // where there are no more rows than unknowns.
  double VarianceFactor() const;
};

// What the data of a system holds. Rotations count as arc lengths at the points' RMS distance and
// sums are taken per weight, so that eigenvalues are without unit, from 0 (a direction that the
// data does not hold) to 1.
struct Observability {
  Vector6d eigenvalues = Vector6d::Zero();  // ascending
  Matrix6d directions = Matrix6d::Zero();   // columns of these: increments (w [rad], v [m])
  Matrix6d coordinates = Matrix6d::Zero();  // rows: increment -> its parts along them
  int free_count = 6;                       // the first ones are not held

  bool Degenerate() const { return free_count > 0; }
  // The increment without what it has along free directions.
  Vector6d Held(const Vector6d& increment) const;
  // The free ones of the directions: each moves the points by about a metre.
  std::vector<Vector6d> FreeDirections() const;
};

// What the data must say of a direction of motion for it to be held.
struct HeldOptions {
  // The least eigenvalue, without unit. 1e-6 is what rounding leaves of zero. Errors of the normals
  // that both surfaces share feign up to 3e-4 in exact views of walls, spheres and corridors, where
  // views of rooms have 5e-3 and more; but what is small and far has small eigenvalues as well.
  double min_eigenvalue = 1e-6;
  // So many times what noise of the normals feigns; 0 = off. Along a plane the ratio is one, and
  // ICP goes a share of 1 - 1 / ratio of its way.
  double min_information_ratio = 0;

  void Visit(OptionVisitor& visitor);
};

// Directions x are free where x^T H x is not above what the options ask for, in the metric of the
// eigenvalues. The directions diagonalise both sides.
Observability Observe(const NormalSystem& system, const HeldOptions& options);

// The least-squares increment among those without part along free directions.
Vector6d SolveHeld(const NormalSystem& system, const Observability& observability);

// Neighbouring points whose errors are one: as many as the window of the depth filter has.
inline constexpr double kSharedPoints = 25;

// What the data can be trusted to say of the increment (1/rad^2, 1/m^2). The points' Hessian is
// taken without FeignedInformation(): in the directions that diagonalise both, where H x = mu F x,
// a share of 1 - 1 / mu of it is left, and none where mu < 1. kSharedPoints count as one. Of the
// intensities' Hessian the given share counts.
Matrix6d TrustedInformation(const NormalSystem& system, double photometric_share);

// Covariance of the increment (rad, m), the inverse information times the variance factor. Only
// where nothing is free.
Matrix6d CovarianceOf(const NormalSystem& system);

// The covariance of an increment (w, v) whose components are independent.
inline Matrix6d Variances(double sigma_rad, double sigma_m) {
  Vector6d sigmas;
  sigmas << Eigen::Vector3d::Constant(sigma_rad), Eigen::Vector3d::Constant(sigma_m);
  return sigmas.cwiseAbs2().asDiagonal();
}

}  // namespace surfit
