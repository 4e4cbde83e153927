#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/SparseCholesky>
#include <vector>

#include "optimization/refinement/reduced_system.h"

namespace surfit {

// A Cholesky factor L L^T of the poses' part P of a reduced hessian, without the first pose, which
// is held.
//
// By Eigen's sparse solver, in minimum degree order, or by its dense one where that is faster: in a
// room that is seen all over again half of all pairs share surfels, and the factor of those is
// nearly full. Both run on one thread.
class PoseFactor {
 public:
  // Orders the unknowns and counts the operations.
  explicit PoseFactor(const BlockPattern& pattern);

  bool is_dense() const { return is_dense_; }

  // Of S P S + damping I, with ones on the diagonal of S P S in any case: scale, the diagonal of S,
  // makes them ones or is zero. False if that is not positive definite.
  bool Factorize(const ReducedSystem& system, const Eigen::VectorXd& scale, double damping);

  Eigen::MatrixXd Solve(const Eigen::MatrixXd& right) const;

  // The block of the inverse for a pose from 1 on.
  ReducedSystem::PoseMatrix InverseBlock(int pose) const;

 private:
  struct SparseLlt : Eigen::SimplicialLLT<Eigen::SparseMatrix<double>, Eigen::Lower> {
    // Multiplications that factorising takes, about; after analyzePattern().
    double Operations() const { return m_nonZerosPerCol.cast<double>().squaredNorm() / 2; }
  };
  // How many times as many operations the dense solver does in the same time, about: 6 with 1300
  // unknowns, 10 with 2300.
  static constexpr double kDenseSpeed = 10;

  Eigen::Index size_;
  SparseLlt sparse_llt_;
  Eigen::MatrixXd dense_;  // its lower triangle is L
  bool is_dense_;
};

// The step to the least of the quadratic model of a cost, damped.
struct ReducedStep {
  Eigen::VectorXd increments;  // of poses and calibration; zero of what is held
  double rho_decrease = 0;     // that the model promises without the damping
};

// Covariances for errors of unit variance: blocks of the inverse of the reduced hessian, so that
// all else is free, but for the first pose and what of the calibration is held.
struct JointCovariance {
  Eigen::MatrixXd calibration;  // 11 x 11; rows and columns of held numbers are zero
  // Of each pose's increment (w [rad], v [m]), 6 x 6: zero of the first, infinite on the diagonal
  // of poses that share no surfel.
  std::vector<Eigen::MatrixXd> poses;
};

// A factor of a reduced hessian: that of its poses, with the calibration, which all poses share, as
// its dense border. Scaled to a diagonal of ones, as metres, radians and pixels differ by orders of
// magnitude:
//   S H S + damping I = [P B; B^T C],  (C - B^T P^-1 B) dense.
// What is held, or in no residual, has zeros in S and a one on the diagonal: it stays where it is.
class ReducedFactor {
 public:
  ReducedFactor(const BlockPattern& pattern, const std::vector<bool>& held_calibration);

  // False if the damped hessian is not positive definite.
  bool Factorize(const ReducedSystem& system, double damping);

  ReducedStep Solve(const Eigen::VectorXd& gradient) const;
  JointCovariance Covariance() const;

 private:
  using CalibrationMatrix = ReducedSystem::CalibrationMatrix;

  void SetScale(const ReducedSystem& system);
  Eigen::MatrixXd ScaledBorder(const ReducedSystem& system) const;
  Eigen::MatrixXd PoseCovariance(int pose) const;

  std::vector<bool> held_calibration_;
  double damping_ = 0;
  Eigen::VectorXd scale_;
  PoseFactor poses_;
  Eigen::MatrixXd border_, solved_border_;  // B and P^-1 B
  Eigen::LLT<CalibrationMatrix> calibration_;
};

// Directions that nothing in the residuals tells have a variance about 1e12 times that which
// their own rows alone would give.
JointCovariance CovarianceOf(const ReducedSystem& system,
                             const std::vector<bool>& held_calibration);

}  // namespace surfit
