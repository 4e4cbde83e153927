#pragma once

#include <ceres/sized_cost_function.h>

#include <cmath>

#include "cost_functions/pose_error.h"

namespace surfit {

// Inverse of the left Jacobian of SO(3): log(exp(d) exp(w)) = w + J d + O(d^2), with
//   J = I - 1/2 [w]x + (1/|w|^2 - (1 + cos|w|) / (2 |w| sin|w|)) [w]x^2, |w| <= pi.
// (Sola, Deray, Atchuthan: A micro Lie theory for state estimation in robotics, 2018, eq. 146.)
inline Eigen::Matrix3d InverseLeftJacobian(const Eigen::Vector3d& w) {
  const double angle2 = w.squaredNorm(), half = std::sqrt(angle2) / 2;
  // (1 + cos a) / sin a = 1 / tan(a/2). The next term of the series is a^4 / 30240.
  const double scale =
      angle2 < 1e-4 ? 1. / 12 + angle2 / 720 : (1 - half / std::tan(half)) / angle2;
  const Eigen::Matrix3d cross = CrossMatrix<double>(w);
  return Eigen::Matrix3d::Identity() - 0.5 * cross + scale * cross * cross;
}

// RelativePose with analytic derivatives. The parameter blocks are the poses world_from_a and
// world_from_b (pose.h). The information is symmetric and positive semidefinite, see RelativePose.
// With A = world_from_a, B = world_from_b and the measurement M = b_from_a, the error is E = A^-1 B
// M:
//   E_R = A_R^T B_R M_R,  E_t = A_R^T y,  y = B_R M_t + B_t - A_t.
// Derivatives by the perturbations of ProductPoseManifold:
//   A_R -> exp(w) A_R: d log(E_R)/dw = -J A_R^T,  dE_t/dw =  A_R^T [y]x,       dE_t/dA_t = -A_R^T
//   B_R -> exp(w) B_R: d log(E_R)/dw =  J A_R^T,  dE_t/dw = -A_R^T [B_R M_t]x, dE_t/dB_t =  A_R^T
// with J = InverseLeftJacobian(log E_R). For Ceres, they are multiplied by dw/d(u, s) = 2 [s I +
// [u]x | -u], the derivative by the quaternion (u, s). The Jacobian of the manifold cancels this
// factor.
class AnalyticRelativePose final : public ceres::SizedCostFunction<6, kPoseSize, kPoseSize> {
 public:
  AnalyticRelativePose(const Rigid3d& a_from_b, const PoseInformation& information)
      : b_from_a_(a_from_b.Inverse()), whiten_(information) {}

  bool Evaluate(double const* const* poses, double* residuals, double** jacobians) const override {
    const Rigid3d world_from_a = PoseFromBlock(poses[0]), world_from_b = PoseFromBlock(poses[1]);
    const Eigen::Matrix3d a_from_world = world_from_a.rotation.conjugate().toRotationMatrix();
    const Eigen::Vector3d arm = world_from_b.rotation * b_from_a_.translation;
    const Eigen::Vector3d y = arm + world_from_b.translation - world_from_a.translation;
    const Rigid3d error(
        (world_from_a.rotation.conjugate() * world_from_b.rotation * b_from_a_.rotation)
            .normalized(),
        a_from_world * y);
    whiten_(error, residuals);
    if (jacobians == nullptr) return true;

    const Eigen::Matrix<double, 6, 3> by_shift = whiten_.root().rightCols<3>() * a_from_world;
    const Eigen::Matrix<double, 6, 3> by_turn =
        whiten_.root().leftCols<3>() *
        (InverseLeftJacobian(QuaternionLog<double>(error.rotation)) * a_from_world);
    if (jacobians[0] != nullptr) {
      Fill(by_shift * CrossMatrix<double>(y) - by_turn, -by_shift, world_from_a, jacobians[0]);
    }
    if (jacobians[1] != nullptr) {
      Fill(by_turn - by_shift * CrossMatrix<double>(arm), by_shift, world_from_b, jacobians[1]);
    }
    return true;
  }

 private:
  using Columns = Eigen::Matrix<double, 6, 3>;

  // Converts derivatives by rotation and translation to derivatives by the pose block.
  static void Fill(const Columns& by_w, const Columns& by_t, const Rigid3d& pose,
                   double* jacobian) {
    const Eigen::Vector3d u = pose.rotation.vec();
    Eigen::Map<Eigen::Matrix<double, 6, kPoseSize, Eigen::RowMajor>> j(jacobian);
    j.leftCols<3>() =
        2 * by_w * (pose.rotation.w() * Eigen::Matrix3d::Identity() + CrossMatrix<double>(u));
    j.col(3) = -2 * by_w * u;
    j.rightCols<3>() = by_t;
  }

  Rigid3d b_from_a_;
  WhitenedPoseError whiten_;
};

}  // namespace surfit
