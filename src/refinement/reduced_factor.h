#pragma once

#include <Eigen/Cholesky>
#include <vector>

#include "refinement/pose_factor.h"

namespace surfit {

// The step to the least of the quadratic model of a cost, damped.
struct ReducedStep {
  Eigen::VectorXd increments;  // of poses and calibration; zero of what is held
  double rho_decrease = 0;     // that the model promises without the damping
};

// Covariances for errors of unit variance: blocks of the inverse of the reduced hessian, so that
// all else is free, but for the first pose and what of the calibration is held.
struct JointCovariance {
  Eigen::MatrixXd calibration;  // 10 x 10; rows and columns of held numbers are zero
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

}  // namespace surfit
