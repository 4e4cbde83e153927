#pragma once

#include "cost_functions/pose_error.h"

namespace surfit {

// RelativePose for initial poses with large errors. Both errors are equal to first order. Parameter
// blocks and information are those of RelativePose. With the measurement Z of a in the frame of b,
//   e = (2 (qx, qy, qz), R_Z^-1 (t_Z - R_b^-1 (t_a - t_b))).
// q is the error quaternion of RelativePose. The length of 2 (qx, qy, qz) is 2 sin(angle / 2). Its
// cost is smooth at an angle of pi, but the cost of the rotation vector has a ridge there. The
// translation is not multiplied by the error rotation, which would dominate its derivatives. It has
// the length of the translation of RelativePose.
class ChordalRelativePose {
 public:
  ChordalRelativePose(const Rigid3d& a_from_b, const PoseInformation& information)
      : b_from_a_(a_from_b.Inverse()), root_(InformationRoot(information)) {}

  template <typename T>
  bool operator()(const T* world_from_a, const T* world_from_b, T* residuals) const {
    const Rigid3<T> a = PoseFromBlock(world_from_a), b = PoseFromBlock(world_from_b);
    const Rigid3<T> measured = b_from_a_.cast<T>();
    const Eigen::Quaternion<T> b_inverse = b.rotation.conjugate();
    Eigen::Matrix<T, 6, 1> e;
    e << T(2) * (a.rotation.conjugate() * b.rotation * measured.rotation).vec(),
        measured.rotation.conjugate() *
            (measured.translation - b_inverse * (a.translation - b.translation));
    Eigen::Map<Eigen::Matrix<T, 6, 1>> r(residuals);
    r = root_.cast<T>() * e;
    return true;
  }

 private:
  Rigid3d b_from_a_;
  PoseInformation root_;
};

}  // namespace surfit
