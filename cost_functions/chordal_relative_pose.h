#pragma once

#include "cost_functions/pose_error.h"

namespace surfit {

// RelativePose with 2 (qx, qy, qz) of the error quaternion instead of the rotation vector.
// Parameter blocks and information are those of RelativePose. The length of the vector is 2
// sin(angle / 2). The cost is smooth at an angle of pi, but the cost of the rotation vector has a
// ridge there. Used for initial poses with large errors.
class ChordalRelativePose {
 public:
  ChordalRelativePose(const Rigid3d& a_from_b, const PoseInformation& information)
      : b_from_a_(a_from_b.Inverse()), root_(InformationRoot(information)) {}

  template <typename T>
  bool operator()(const T* world_from_a, const T* world_from_b, T* residuals) const {
    const Rigid3<T> error =
        PoseFromBlock(world_from_a).Inverse() * PoseFromBlock(world_from_b) * b_from_a_.cast<T>();
    Eigen::Matrix<T, 6, 1> e;
    e << T(2) * error.rotation.vec(), error.translation;
    Eigen::Map<Eigen::Matrix<T, 6, 1>> r(residuals);
    r = root_.cast<T>() * e;
    return true;
  }

 private:
  Rigid3d b_from_a_;
  PoseInformation root_;
};

}  // namespace surfit
