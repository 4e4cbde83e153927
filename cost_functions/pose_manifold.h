#pragma once

#include <ceres/manifold.h>

#include <Eigen/Core>

#include "cost_functions/pose.h"

namespace surfit {

// Base of two manifolds of a pose block (q, t), with left perturbations (w [rad], v [m]). They
// differ in the effect of w on the translation. With the vector part u and the scalar part s of
// q,
//   exp(w) q = q + 1/2 [s w + w x u; -w . u] + O(w^2).
// The Jacobian of Plus is d(u, s)/dw = 1/2 [s I - [u]x; -u^T]. The Jacobian of Minus is its inverse
// on the sphere, dw/d(u, s) = 2 [s I + [u]x | -u].
class PoseManifold : public ceres::Manifold {
 public:
  int AmbientSize() const override { return kPoseSize; }
  int TangentSize() const override { return kPoseTangentSize; }

 protected:
  using PlusMatrix = Eigen::Matrix<double, kPoseSize, kPoseTangentSize, Eigen::RowMajor>;
  using MinusMatrix = Eigen::Matrix<double, kPoseTangentSize, kPoseSize, Eigen::RowMajor>;

  // Jacobians of ProductPoseManifold.
  static PlusMatrix ProductPlusJacobian(const Rigid3d& x) {
    const Eigen::Vector3d u = x.rotation.vec();
    const double s = x.rotation.w();
    PlusMatrix j = PlusMatrix::Zero();
    j.block<3, 3>(0, 0) = 0.5 * (s * Eigen::Matrix3d::Identity() - CrossMatrix<double>(u));
    j.block<1, 3>(3, 0) = -0.5 * u.transpose();
    j.block<3, 3>(4, 3).setIdentity();
    return j;
  }
  static MinusMatrix ProductMinusJacobian(const Rigid3d& x) {
    const Eigen::Vector3d u = x.rotation.vec();
    const double s = x.rotation.w();
    MinusMatrix j = MinusMatrix::Zero();
    j.block<3, 3>(0, 0) = 2 * (s * Eigen::Matrix3d::Identity() + CrossMatrix<double>(u));
    j.block<3, 1>(0, 3) = -2 * u;
    j.block<3, 3>(3, 4).setIdentity();
    return j;
  }
};

// Plus((q, t), (w, v)) = (exp(w) q, exp(w) t + v), the perturbation of the closed-form solvers.
// With y = R p + t, a residual n . (y - q) has the Jacobian [y x n, n].
class LeftPoseManifold final : public PoseManifold {
 public:
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override {
    const Eigen::Map<const Eigen::Matrix<double, 6, 1>> increment(delta);
    PoseToBlock(LeftIncrement<double>(increment, PoseFromBlock(x)), x_plus_delta);
    return true;
  }
  bool PlusJacobian(const double* x, double* jacobian) const override {
    const Rigid3d pose = PoseFromBlock(x);
    Eigen::Map<PlusMatrix> j(jacobian);
    j = ProductPlusJacobian(pose);
    j.block<3, 3>(4, 0) = -CrossMatrix<double>(pose.translation);  // w x t
    return true;
  }
  bool Minus(const double* y, const double* x, double* y_minus_x) const override {
    const Rigid3d from = PoseFromBlock(x);
    Rigid3d to = PoseFromBlock(y);
    to.rotation.normalize();  // the Jacobian also ignores changes of the norm
    const Rigid3d step = to * from.Inverse();
    Eigen::Map<Eigen::Matrix<double, 6, 1>> delta(y_minus_x);
    delta << QuaternionLog<double>(step.rotation), step.translation;
    return true;
  }
  bool MinusJacobian(const double* x, double* jacobian) const override {
    const Rigid3d pose = PoseFromBlock(x);
    Eigen::Map<MinusMatrix> j(jacobian);
    j = ProductMinusJacobian(pose);
    j.block<3, 4>(3, 0) = CrossMatrix<double>(pose.translation) * j.block<3, 4>(0, 0);
    return true;
  }
};

// Plus((q, t), (w, v)) = (exp(w) q, t + v), the product of SO(3) and R^3. A residual n . (y - q)
// has the Jacobian [R p x n, n].
class ProductPoseManifold final : public PoseManifold {
 public:
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override {
    const Rigid3d pose = PoseFromBlock(x);
    const Eigen::Map<const Eigen::Vector3d> w(delta), v(delta + 3);
    PoseToBlock(
        Rigid3d((QuaternionExp<double>(w) * pose.rotation).normalized(), pose.translation + v),
        x_plus_delta);
    return true;
  }
  bool PlusJacobian(const double* x, double* jacobian) const override {
    Eigen::Map<PlusMatrix> j(jacobian);
    j = ProductPlusJacobian(PoseFromBlock(x));
    return true;
  }
  bool Minus(const double* y, const double* x, double* y_minus_x) const override {
    const Rigid3d from = PoseFromBlock(x), to = PoseFromBlock(y);
    Eigen::Map<Eigen::Matrix<double, 6, 1>> delta(y_minus_x);
    delta << QuaternionLog<double>(to.rotation * from.rotation.conjugate()),
        to.translation - from.translation;
    return true;
  }
  bool MinusJacobian(const double* x, double* jacobian) const override {
    Eigen::Map<MinusMatrix> j(jacobian);
    j = ProductMinusJacobian(PoseFromBlock(x));
    return true;
  }
};

}  // namespace surfit
