#pragma once

#include <Eigen/Core>
#include <Eigen/Eigenvalues>

#include "cost_functions/pose.h"

namespace surfit {

// Measured position z of a sensor (GPS antenna) at p in the frame of a pose, three residuals:
// U (R p + t - z), in m along the axes of the world, with U^T U = information.
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
