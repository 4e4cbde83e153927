#pragma once

#include <Eigen/Core>
#include <utility>

#include "cost_functions/pose.h"

namespace surfit {

// Adapts a functor of a pose block (pose.h) to one block [wx wy wz tx ty tz] of six parameters. The
// rotation vector w is in rad, the translation t in m. Needs no manifold. Singular at |w| = 2 pi.
template <typename Functor>
struct WithAngleAxisPose {
  explicit WithAngleAxisPose(Functor functor_of_pose) : functor(std::move(functor_of_pose)) {}

  template <typename T>
  bool operator()(const T* angle_axis_and_translation, T* residuals) const {
    const Eigen::Map<const Eigen::Matrix<T, 3, 1>> w(angle_axis_and_translation),
        t(angle_axis_and_translation + 3);
    T pose[kPoseSize];
    PoseToBlock(Rigid3<T>(QuaternionExp<T>(w), t), pose);
    return functor(pose, residuals);
  }

  Functor functor;
};

}  // namespace surfit
