#pragma once

#include <array>
#include <cmath>

#include "cost_functions/pose.h"
#include "surfit/geometry/inverse_depth_field.h"

namespace surfit {

// The parameter block of a depth camera's calibration: [fx fy cx cy c0 .. c5], px and 1/m (see
// InverseDepthField).
inline constexpr int kCalibrationSize = 4 + static_cast<int>(InverseDepthField::kSize);
inline constexpr int kFieldBegin = 4;

// r = (1/z_measured + c(x, y) - 1/z_plane) / sigma, one residual: the corrected inverse depth of a
// pixel against that of a surfel's plane where the pixel's ray meets it. With the plane's unit
// normal n and a point p of it in the world, moved by a displacement d along n, the pose (R, t)
// world_from_camera and the ray e = ((u - cx)/fx, (v - cy)/fy, 1),
//   1/z_plane = n . R e / (n . (p - t) + d).
// It is the point-to-plane distance over that of the camera from the plane, and over the depth.
// As an error of what the sensor measures, inverse depth, it has the same sigma whatever the
// calibration: errors in metres would be least for a calibration that makes all depths small.
class PlaneInverseDepth {
 public:
  // A pixel (u, v) in px, its measured inverse depth and sigma in 1/m; p in metres.
  PlaneInverseDepth(double u, double v, double inverse_depth, double sigma,
                    const Eigen::Vector3d& point_in_world, const Eigen::Vector3d& normal_in_world)
      : u_(u), v_(v), inverse_depth_(inverse_depth), inverse_sigma_(1 / sigma) {
    for (int i = 0; i < 3; ++i) {
      point_[i] = point_in_world[i];
      normal_[i] = normal_in_world[i];
    }
  }

  // Pose block (pose.h), calibration block, displacement in metres.
  template <typename T>
  bool operator()(const T* pose, const T* calibration, const T* displacement, T* residual) const {
    const T ray[3] = {(u_ - calibration[2]) / calibration[0],
                      (v_ - calibration[3]) / calibration[1], T(1)};
    T turned[3];
    RotateByPose(pose, ray, turned);
    T along_ray(0), from_camera = displacement[0];
    for (int i = 0; i < 3; ++i) {
      along_ray += normal_[i] * turned[i];
      from_camera += normal_[i] * (point_[i] - pose[4 + i]);
    }
    T corrected(inverse_depth_);
    const auto basis = InverseDepthField::Basis(ray[0], ray[1]);
    for (std::size_t i = 0; i < basis.size(); ++i) {
      corrected += calibration[kFieldBegin + i] * basis[i];
    }
    residual[0] = (corrected - along_ray / from_camera) * inverse_sigma_;
    return true;
  }

 private:
  double u_, v_, inverse_depth_, inverse_sigma_;
  std::array<double, 3> point_, normal_;
};

}  // namespace surfit
