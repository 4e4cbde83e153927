#pragma once

#include <Eigen/Core>
#include <Eigen/Eigenvalues>

#include "cost_functions/pose.h"

namespace surfit {

// Measured position z (m, world frame) of a sensor (GPS antenna) at p (m, frame of the pose). The
// three residuals are U (R p + t - z), in standard deviations, with U^T U = information (1/m^2) and
// (R, t) = world_from_pose. The information must be symmetric. Its negative eigenvalues are set to
// 0.
class SensorPosition {
 public:
  SensorPosition(const Eigen::Vector3d& sensor_in_pose, const Eigen::Vector3d& sensor_in_world,
                 const Eigen::Matrix3d& information)
      : sensor_in_pose_(sensor_in_pose), sensor_in_world_(sensor_in_world) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(information);
    root_ =
        eigen.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal() * eigen.eigenvectors().transpose();
  }

  template <typename T>
  bool operator()(const T* world_from_pose, T* residuals) const {
    Eigen::Matrix<T, 3, 1> e;
    MovePoint(world_from_pose, sensor_in_pose_.data(), e.data());
    Eigen::Map<Eigen::Matrix<T, 3, 1>> r(residuals);
    r = root_.cast<T>() * (e - sensor_in_world_.cast<T>());
    return true;
  }

 private:
  Eigen::Vector3d sensor_in_pose_, sensor_in_world_;
  Eigen::Matrix3d root_;
};

}  // namespace surfit
