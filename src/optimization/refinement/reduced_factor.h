#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/SparseCholesky>
#include <vector>

#include "optimization/refinement/reduced_system.h"

namespace surfit {

// Cholesky factor of the pose part P of a reduced Hessian, without the fixed first pose.
//
// Uses the dense solver of Eigen if it is faster than the sparse solver: in a single room, half of
// all keyframe pairs share surfels. Runs on one thread. All systems must have the pattern of the
// constructor. Call Factorize() before the other functions.
class PoseFactor {
 public:
  explicit PoseFactor(const BlockPattern& pattern);

  bool is_dense() const { return is_dense_; }

  // Factorises S P S + damping I, with the diagonal S of `scale`. The diagonal of S P S is set
  // to 1. Returns false if the matrix is not positive definite.
  bool Factorize(const ReducedSystem& system, const Eigen::VectorXd& scale, double damping);

  // Solves (S P S + damping I) X = right. Rows exclude the first pose.
  Eigen::MatrixXd Solve(const Eigen::MatrixXd& right) const;

  // Diagonal block of the inverse. `pose` must be at least 1. The inverse is that of S P S +
  // damping I.
  ReducedSystem::PoseMatrix InverseBlock(int pose) const;

 private:
  struct SparseLlt : Eigen::SimplicialLLT<Eigen::SparseMatrix<double>, Eigen::Lower> {
    // Approximate number of multiplications of a factorisation. Call after analyzePattern().
    double Operations() const { return m_nonZerosPerCol.cast<double>().squaredNorm() / 2; }
  };
  // Operations per second of the dense solver relative to the sparse solver. Measured: 6 with
  // 1300 unknowns, 10 with 2300.
  static constexpr double kDenseSpeed = 10;

  Eigen::Index size_;
  SparseLlt sparse_llt_;
  Eigen::MatrixXd dense_;  // its lower triangle is L
  bool is_dense_;
};

// Step of the joint problem.
struct ReducedStep {
  Eigen::VectorXd increments;  // of poses and calibration; 0 for fixed parameters
  double rho_decrease = 0;     // predicted decrease of rho, without the damping
};

// Marginal covariances for residuals of unit variance: blocks of the inverse of the reduced
// Hessian.
struct JointCovariance {
  Eigen::MatrixXd calibration;  // 11 x 11; rows and columns of fixed parameters are 0
  // Covariance of each pose perturbation (w [rad], v [m]), 6 x 6. 0 for the first pose.
  // Infinite diagonal for poses without residuals.
  std::vector<Eigen::MatrixXd> poses;
};

// Quadratic model of the cost as a function of the calibration, about a linearisation point.
struct CalibrationModel {
  ReducedSystem::CalibrationMatrix information = ReducedSystem::CalibrationMatrix::Zero();
  CalibrationRow gradient = CalibrationRow::Zero();

  CalibrationModel operator+(const CalibrationModel& other) const {
    return {information + other.information, gradient + other.gradient};
  }
  // Removes the dependence on a parameter.
  void Fix(int parameter) {
    information.row(parameter).setZero();
    information.col(parameter).setZero();
    gradient[parameter] = 0;
  }
};

// Factor of a reduced Hessian. All poses depend on the calibration, which is a dense border of the
// pose part. It is scaled to a unit diagonal, because metres, radians and pixels differ by orders
// of magnitude:
//   S H S + damping I = [P B; B^T C],  (C - B^T P^-1 B) dense.
// Parameters that are fixed or without residuals have 0 in S and 1 on the diagonal: they do not
// change.
class ReducedFactor {
 public:
  // `fixed_calibration` has kCalibrationSize values.
  ReducedFactor(const BlockPattern& pattern, const std::vector<bool>& fixed_calibration);

  // Returns false if the matrix is not positive definite. Call before Solve() and Covariance(),
  // which require success.
  bool Factorize(const ReducedSystem& system, double damping);

  // Levenberg-Marquardt step for a gradient of the factorised system.
  ReducedStep Solve(const Eigen::VectorXd& gradient) const;
  // Covariance at the factorised system, including its damping.
  JointCovariance Covariance() const;
  // Cost at the optimal poses, as a function of the calibration. Fixed parameters have no effect.
  CalibrationModel Marginal(const Eigen::VectorXd& gradient) const;

 private:
  using CalibrationMatrix = ReducedSystem::CalibrationMatrix;

  void SetScale(const ReducedSystem& system);
  Eigen::MatrixXd ScaledBorder(const ReducedSystem& system) const;
  Eigen::MatrixXd PoseCovariance(int pose) const;

  std::vector<bool> fixed_calibration_;
  double damping_ = 0;
  Eigen::VectorXd scale_;
  PoseFactor poses_;
  Eigen::MatrixXd border_, solved_border_;  // B and P^-1 B
  Eigen::LLT<CalibrationMatrix> calibration_;
};

// Covariance, with the smallest damping that allows a factorisation. Unobservable directions get
// a variance of about 1e12 times the inverse of their diagonal elements.
JointCovariance CovarianceOf(const ReducedSystem& system,
                             const std::vector<bool>& fixed_calibration);
// ReducedFactor::Marginal() of a system, with the smallest damping that allows a factorisation.
CalibrationModel MarginalOf(const ReducedSystem& system,
                            const std::vector<bool>& fixed_calibration);

}  // namespace surfit
