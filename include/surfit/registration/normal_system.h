#pragma once

#include <Eigen/Core>
#include <vector>

namespace surfit {

class OptionVisitor;

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

// Photometric part of a NormalSystem, with the symbols of ErrorModel. w = W rho_I'(s_I) /
// intensity_sigma^2 is the weight of a point.
struct PhotometricSystem {
  Matrix6d hessian = Matrix6d::Zero();
  Vector6d right_side = Vector6d::Zero();
  double cost = 0;        // 1/2 sum of W rho_I(s_I)
  double square_sum = 0;  // sum of w r_I^2, without unit
  int row_count = 0;

  PhotometricSystem& operator+=(const PhotometricSystem& other);
};

// Normal equations at the current pose, for the left perturbation (w, v) [rad, m] in the target
// frame. It moves p' to exp(w) p' + v = p' + w x p' + v + O(w^2). A residual has Jacobian rows a
// with r(w, v) = a . (w, v) + r; residual_rows.h derives them for each ResidualType. A has the rows
// of all correspondences, and W is the diagonal matrix of their weights w = rho'(s) / sigma^2
// (ErrorModel). The least-squares increment x solves A^T W A x = -A^T W r. The centre of rotation
// is the target camera, so the conditioning does not depend on the origin of the world frame.
struct NormalSystem {
  Matrix6d hessian = Matrix6d::Zero();     // A^T W A
  Vector6d right_side = Vector6d::Zero();  // -A^T W r
  double cost = 0;                         // 1/2 sum of rho(s), see ErrorModel
  double weighted_square_sum = 0;          // sum of w |r|^2, without unit
  double weight_sum = 0;                   // sum of w, 1/m^2
  double normal_difference_sum = 0;        // sum of w |m - n|
  double normal_ratio = 0;                 // ratio of the normal variance in the rows: 0, 0.5 or 1
  Eigen::Vector3d point_sum = Eigen::Vector3d::Zero();          // sum of w p'
  Eigen::Matrix3d point_product_sum = Eigen::Matrix3d::Zero();  // sum of w p' p'^T
  int row_count = 0;     // residuals: correspondences times components
  int pair_count = 0;    // correspondences
  int inlier_count = 0;  // residual within ErrorModel::kInlierSigmas

  // Photometric part of `hessian` and `right_side`. All other members are geometric.
  PhotometricSystem photometric;

  NormalSystem& operator+=(const NormalSystem& other);
  // Adds photometric rows to `hessian`, `right_side` and `photometric`.
  void Add(const PhotometricSystem& intensities);

  // Weighted mean of |r|^2 in m^2. 0 without correspondences.
  double AverageLoss() const { return weight_sum > 0 ? weighted_square_sum / weight_sum : 0; }

  // Geometric and photometric loss in m^2 for the convergence test. A step that reduces the total
  // loss can increase AverageLoss().
  double JointLoss() const {
    return weight_sum > 0 ? (weighted_square_sum + photometric.square_sum) / weight_sum : 0;
  }
  double JointCost() const { return cost + photometric.cost; }

  // Square root of the weighted mean of |p'|^2, m: distance of the points from the target camera. 0
  // without correspondences.
  double RmsDistance() const;

  // Spurious information: contribution of normal noise to the Hessian. A row is a = n G with G =
  // [-[p']x | I]. Normal noise of variance s^2, in both directions across n, adds s^2 (G^T G - a^T
  // a) on average. The system then seems to constrain unobservable directions. For equally noisy
  // normals of the same surface the mean of |m - n| is s sqrt(pi). The mean of squares is not used,
  // because it is dominated by a few correspondences of different surfaces.
  Matrix6d SpuriousInformation() const;

  // Variance factor of the residuals: sum of w |r|^2 per degree of freedom. 1 if there are at most
  // 6 rows.
  double VarianceFactor() const;
};

// Observable and unobservable directions of a system. Rotations are measured as arc lengths at
// RmsDistance(), and sums are divided by weight_sum. Eigenvalues are therefore dimensionless: 0
// along unobservable directions, of the order of 1 along well constrained ones.
struct Observability {
  Vector6d eigenvalues = Vector6d::Zero();  // of the Hessian, ascending
  Matrix6d directions = Matrix6d::Zero();   // columns: increments (w [rad], v [m])
  Matrix6d coordinates = Matrix6d::Zero();  // rows: increment -> coordinates in `directions`
  int degenerate_count = 6;  // number of unobservable directions, which are the first columns

  bool Degenerate() const { return degenerate_count > 0; }
  // Projects an increment to the observable directions. 0 without correspondences.
  Vector6d Held(const Vector6d& increment) const;
  // Unobservable directions. Each moves the points by about 1 m. Six zero vectors without
  // correspondences.
  std::vector<Vector6d> DegenerateDirections() const;
};

// Thresholds for a direction to be observable.
struct ObservabilityOptions {
  // Minimum eigenvalue, dimensionless. Rounding errors reach 1e-6. Normal errors that both surfaces
  // share cause up to 3e-4 in noise-free views of walls, spheres and corridors. Views of rooms have
  // 5e-3 and more, but small distant surfaces also have small eigenvalues.
  double min_eigenvalue = 1e-6;
  // Minimum ratio of information to spurious information; 0: off. The ratio is 1 along a plane.
  // An ICP step covers 1 - 1 / ratio of the remaining distance.
  double min_information_ratio = 0;

  void Visit(OptionVisitor& visitor);
};

// Determines the unobservable directions x: x^T H x is at most the threshold of `options`, in the
// metric of the eigenvalues. All six are unobservable without correspondences, or if the system is
// not finite. `directions` diagonalises both the Hessian and the threshold matrix.
Observability Observe(const NormalSystem& system, const ObservabilityOptions& options);

// Least-squares increment (w [rad], v [m]) in the subspace of observable directions. 0 if there are
// none.
Vector6d SolveObservable(const NormalSystem& system, const Observability& observability);

// Number of neighbouring points with fully correlated errors: the window size of the depth filter.
inline constexpr double kSharedPoints = 25;

// Conservative information of the increment (1/rad^2, 1/m^2). Subtracts the spurious information F
// from the geometric Hessian H. For H x = mu F x, this multiplies the information along x by 1 - 1
// / mu, or by 0 if mu < 1. Adds the photometric Hessian times `photometric_ratio`. Divides the sum
// by kSharedPoints and by the variance factor (at least 1e-3). 0 without correspondences.
Matrix6d ConservativeInformation(const NormalSystem& system, double photometric_ratio);

// Covariance of the increment (rad, m): inverse Hessian times the variance factor. Requires that
// all directions are observable.
Matrix6d CovarianceOf(const NormalSystem& system);

// Covariance of an increment (w, v) with independent components.
inline Matrix6d Variances(double sigma_rad, double sigma_m) {
  Vector6d sigmas;
  sigmas << Eigen::Vector3d::Constant(sigma_rad), Eigen::Vector3d::Constant(sigma_m);
  return sigmas.cwiseAbs2().asDiagonal();
}

}  // namespace surfit
