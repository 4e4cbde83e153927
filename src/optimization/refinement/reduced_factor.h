#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/SparseCholesky>
#include <vector>

#include "optimization/refinement/reduced_system.h"

namespace surfit {

// Cholesky factor L L^T of the pose part P of a reduced Hessian, without the fixed first pose.
//
// Uses the sparse solver of Eigen with minimum degree ordering, or the dense solver if it is
// faster. In a room that is seen repeatedly, half of all keyframe pairs share surfels, and the
// sparse factor is nearly full. Both solvers run on one thread.
class PoseFactor {
 public:
  // Computes the ordering and the number of operations.
  explicit PoseFactor(const BlockPattern& pattern);

  bool is_dense() const { return is_dense_; }

  // Factorises S P S + damping I. `scale` is the diagonal of S. It normalises the diagonal of P to
  // 1, or is 0 for parameters without residuals, whose diagonal is set to 1. Returns false if the
  // matrix is not positive definite.
  bool Factorize(const ReducedSystem& system, const Eigen::VectorXd& scale, double damping);

  Eigen::MatrixXd Solve(const Eigen::MatrixXd& right) const;

  // Diagonal block of the inverse for a pose, from pose 1.
  ReducedSystem::PoseMatrix InverseBlock(int pose) const;

 private:
  struct SparseLlt : Eigen::SimplicialLLT<Eigen::SparseMatrix<double>, Eigen::Lower> {
    // Approximate number of multiplications of a factorisation. Call after analyzePattern().
    double Operations() const { return m_nonZerosPerCol.cast<double>().squaredNorm() / 2; }
  };
  // Approximate speed of the dense solver relative to the sparse solver, per operation: 6 with 1300
  // unknowns, 10 with 2300.
  static constexpr double kDenseSpeed = 10;

  Eigen::Index size_;
  SparseLlt sparse_llt_;
  Eigen::MatrixXd dense_;  // its lower triangle is L
  bool is_dense_;
};

// Damped step to the minimum of the quadratic model of the cost.
struct ReducedStep {
  Eigen::VectorXd increments;  // of poses and calibration; 0 for fixed parameters
  double rho_decrease = 0;     // predicted decrease of rho, without the damping
};

// Marginal covariances for residuals of unit variance: blocks of the inverse of the reduced
// Hessian. The first pose and fixed calibration parameters are constant.
struct JointCovariance {
  Eigen::MatrixXd calibration;  // 11 x 11; rows and columns of fixed parameters are 0
  // Covariance of each pose perturbation (w [rad], v [m]), 6 x 6. 0 for the first pose, infinite on
  // the diagonal of poses without shared surfels.
  std::vector<Eigen::MatrixXd> poses;
  // Calibration rows of the inverse Hessian, 11 x (6 poses + 11). 0 for fixed parameters.
  Eigen::MatrixXd calibration_rows;
};

// Factor of a reduced Hessian. All poses depend on the calibration, which is a dense border of the
// pose part. It is scaled to a unit diagonal, because metres, radians and pixels differ by orders
// of magnitude:
//   S H S + damping I = [P B; B^T C],  (C - B^T P^-1 B) dense.
// Parameters that are fixed or without residuals have 0 in S and 1 on the diagonal: they do not
// change.
class ReducedFactor {
 public:
  ReducedFactor(const BlockPattern& pattern, const std::vector<bool>& fixed_calibration);

  // Returns false if the damped Hessian is not positive definite.
  bool Factorize(const ReducedSystem& system, double damping);

  ReducedStep Solve(const Eigen::VectorXd& gradient) const;
  JointCovariance Covariance() const;

 private:
  using CalibrationMatrix = ReducedSystem::CalibrationMatrix;

  void SetScale(const ReducedSystem& system);
  Eigen::MatrixXd ScaledBorder(const ReducedSystem& system) const;
  Eigen::MatrixXd PoseCovariance(int pose) const;
  Eigen::MatrixXd CalibrationRows() const;

  std::vector<bool> fixed_calibration_;
  double damping_ = 0;
  Eigen::VectorXd scale_;
  PoseFactor poses_;
  Eigen::MatrixXd border_, solved_border_;  // B and P^-1 B
  Eigen::LLT<CalibrationMatrix> calibration_;
};

// Covariance by the smallest damping that can be factorised. The variance of unobservable
// directions is about 1e12 times the variance that their diagonal elements alone would give.
JointCovariance CovarianceOf(const ReducedSystem& system,
                             const std::vector<bool>& fixed_calibration);

}  // namespace surfit
