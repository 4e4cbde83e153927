#pragma once

#include <Eigen/Core>
#include <cmath>

#include "cost_functions/pose.h"
#include "surfit/geometry/inverse_depth_field.h"

namespace surfit {

// The parameter block of a depth camera's calibration: [fx fy cx cy c0 .. c5 T], px and 1/m (see
// InverseDepthField), and the readout T of a rolling shutter, s.
inline constexpr int kFieldBegin = 4;
inline constexpr int kReadout = kFieldBegin + static_cast<int>(InverseDepthField::kSize);
inline constexpr int kCalibrationSize = kReadout + 1;

// How the camera moves while a pixel's row waits to be read: the row of share s of the readout,
// from -1/2 to 1/2, is read s T after its middle.
struct RowMotion {
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();  // s times the camera's turn, rad/s
  Eigen::Vector3d way = Eigen::Vector3d::Zero();   // s times its velocity, m/s
  double readout_s = 0;  // by which pixel and depth were brought to the middle already
};

// r = (1/z_measured + c(x, y) - 1/z_plane) / sigma, one residual: the corrected inverse depth of a
// pixel against that of a surfel's plane where the pixel's ray meets it. With the plane's unit
// normal n and a point p of it in the world, moved by a displacement d along n, the pose (R, t)
// world_from_camera and the ray e = ((u - cx)/fx, (v - cy)/fy, 1),
//   1/z_plane = n . R e / (n . (p - t) + d).
// With a readout that is longer by dT than the pixel's own, the point X it measures lies at
// X + dT (turn x X + way) (AtMiddleOfReadout()), so that e + dT turn x e stands for e above, and
// t + dT R way for t.
// It is the point-to-plane distance over that of the camera from the plane, and over the depth.
// As an error of what the sensor measures, inverse depth, it has the same sigma whatever the
// calibration: errors in metres would be least for a calibration that makes all depths small.
class PlaneInverseDepth {
 public:
  // A pixel (u, v) in px, its measured inverse depth and sigma in 1/m; p in metres.
  PlaneInverseDepth(double u, double v, double inverse_depth, double sigma,
                    const Eigen::Vector3d& point_in_world, const Eigen::Vector3d& normal_in_world,
                    const RowMotion& motion = {})
      : u_(u),
        v_(v),
        inverse_depth_(inverse_depth),
        inverse_sigma_(1 / sigma),
        point_(point_in_world),
        normal_(normal_in_world),
        motion_(motion) {}

  // Pose block (pose.h), calibration block, displacement in metres.
  template <typename T>
  bool operator()(const T* pose, const T* calibration, const T* displacement, T* residual) const {
    const T ray[3] = {(u_ - calibration[2]) / calibration[0],
                      (v_ - calibration[3]) / calibration[1], T(1)};
    const T later = calibration[kReadout] - motion_.readout_s;
    T at_row[3], way[3], turned[3], turned_way[3];
    Cross(motion_.turn.data(), ray, at_row);
    for (int i = 0; i < 3; ++i) {
      at_row[i] = ray[i] + later * at_row[i];
      way[i] = later * motion_.way[i];
    }
    RotateByPose(pose, at_row, turned);
    RotateByPose(pose, way, turned_way);
    T along_ray(0), from_camera = displacement[0];
    for (int i = 0; i < 3; ++i) {
      along_ray += normal_[i] * turned[i];
      from_camera += normal_[i] * (point_[i] - pose[4 + i] - turned_way[i]);
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
  Eigen::Vector3d point_, normal_;
  RowMotion motion_;
};

}  // namespace surfit
