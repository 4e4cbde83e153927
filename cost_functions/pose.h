#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "surfit/geometry/rigid3.h"

namespace surfit {

// Parameter block of a pose target_from_source: [qx qy qz qw tx ty tz]. Unit quaternion in the
// order of Eigen and TUM files, translation in m.
inline constexpr int kPoseSize = 7;
inline constexpr int kPoseTangentSize = 6;  // (w [rad], v [m])
inline constexpr double kIdentityBlock[kPoseSize] = {0, 0, 0, 1, 0, 0, 0};

// Does not normalise the quaternion.
template <typename T>
Rigid3<T> PoseFromBlock(const T* pose) {
  return Rigid3<T>(Eigen::Quaternion<T>(pose[3], pose[0], pose[1], pose[2]),
                   Eigen::Matrix<T, 3, 1>(pose[4], pose[5], pose[6]));
}

// Copies the pose to the block, without normalising the quaternion.
template <typename T>
void PoseToBlock(const Rigid3<T>& pose, T* block) {
  for (int i = 0; i < 4; ++i) block[i] = pose.rotation.coeffs()[i];
  for (int i = 0; i < 3; ++i) block[4 + i] = pose.translation[i];
}

// result = a x b. `result` must be another array than a and b.
template <typename A, typename B, typename T>
void Cross(const A* a, const B* b, T* result) {
  result[0] = a[1] * b[2] - a[2] * b[1];
  result[1] = a[2] * b[0] - a[0] * b[2];
  result[2] = a[0] * b[1] - a[1] * b[0];
}

// result = R x - x = w 2 (u x x) + u x 2 (u x x) for the unit quaternion (u, w) of the pose block.
template <typename T, typename D>
void TurnByPose(const T* pose, const D* x, T* result) {
  T twice[3], across[3];
  Cross(pose, x, twice);
  for (T& value : twice) value = value + value;
  Cross(pose, twice, across);
  for (int i = 0; i < 3; ++i) result[i] = pose[3] * twice[i] + across[i];
}

// result = R x, with the rotation R of the pose block. `result` must be another array than x, here
// and in the functions below.
template <typename T, typename D>
void RotateByPose(const T* pose, const D* x, T* result) {
  TurnByPose(pose, x, result);
  for (int i = 0; i < 3; ++i) result[i] = result[i] + x[i];
}

// y = R p + t, in the target frame for a point p in the source frame.
template <typename T, typename D>
void MovePoint(const T* pose, const D* p, T* y) {
  RotateByPose(pose, p, y);
  for (int i = 0; i < 3; ++i) y[i] = y[i] + pose[4 + i];
}

}  // namespace surfit
