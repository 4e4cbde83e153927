#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <cmath>

#include "cost_functions/pose_error.h"

namespace surfit {

// Parameter block of a pose in SE(2): [x (m), y (m), angle (rad)]. The angle is not bounded.
inline constexpr int kPlanarSize = 3;

// Lifts a pose of SE(2) to a parameter block of SE(3) with z = 0.
template <typename T>
void LiftPlanarPose(const T* planar, T* pose) {
  using std::cos;
  using std::sin;
  const T half = planar[2] / T(2);
  pose[0] = pose[1] = T(0);
  pose[2] = sin(half);
  pose[3] = cos(half);
  pose[4] = planar[0];
  pose[5] = planar[1];
  pose[6] = T(0);
}

// Inverse of LiftPlanarPose(), with an angle in [-pi, pi]. Requires a rotation about z.
inline void PlanarFromPose(const Rigid3d& pose, double* planar) {
  planar[0] = pose.translation.x();
  planar[1] = pose.translation.y();
  planar[2] = QuaternionLog<double>(pose.rotation).z();
}

// Evaluates a cost functor of poses in SE(3) at poses in SE(2).
template <typename Functor>
class PlanarFunctor {
 public:
  explicit PlanarFunctor(const Functor& functor) : functor_(functor) {}

  template <typename T>
  bool operator()(const T* planar, T* residuals) const {
    T pose[kPoseSize];
    LiftPlanarPose(planar, pose);
    return functor_(pose, residuals);
  }

 private:
  Functor functor_;
};

// RelativePose in SE(2), three residuals. With poses (t_a, alpha) and (t_b, beta) and the
// measurement b_from_a = (m, mu), the error is
//   w = beta - alpha + mu, in [-pi, pi),   v = R(-alpha) (R(beta) m + t_b - t_a).
// The residuals are U (w, v), in standard deviations, with U^T U = information of (w, v).
class PlanarRelativePose {
 public:
  // Uses the rows (rotation about z, x, y) of a measurement and an information matrix in SE(3).
  PlanarRelativePose(const Rigid3d& a_from_b, const PoseInformation& information) {
    PlanarFromPose(a_from_b.Inverse(), b_from_a_);
    const Eigen::Matrix3d part = information.block<3, 3>(2, 2);
    const Eigen::LLT<Eigen::Matrix3d> cholesky(part);
    if (cholesky.info() == Eigen::Success) {
      root_ = cholesky.matrixU();
    } else {
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(part);
      root_ = eigen.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal() *
              eigen.eigenvectors().transpose();
    }
  }

  template <typename T>
  bool operator()(const T* a, const T* b, T* residuals) const {
    using std::cos;
    using std::floor;
    using std::sin;
    const T cos_a = cos(a[2]), sin_a = sin(a[2]), cos_b = cos(b[2]), sin_b = sin(b[2]);
    const T x = cos_b * b_from_a_[0] - sin_b * b_from_a_[1] + b[0] - a[0];
    const T y = sin_b * b_from_a_[0] + cos_b * b_from_a_[1] + b[1] - a[1];
    const T angle = b[2] - a[2] + b_from_a_[2];
    Eigen::Matrix<T, 3, 1> e;
    e << angle - 2 * M_PI * floor((angle + M_PI) / (2 * M_PI)), cos_a * x + sin_a * y,
        cos_a * y - sin_a * x;
    Eigen::Map<Eigen::Matrix<T, 3, 1>> r(residuals);
    r = root_.cast<T>() * e;
    return true;
  }

 private:
  double b_from_a_[kPlanarSize];
  Eigen::Matrix3d root_;
};

}  // namespace surfit
