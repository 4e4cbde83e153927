#pragma once

#include <Eigen/Core>
#include <cmath>

#include "cost_functions/pose.h"
#include "surfit/geometry/inverse_depth_field.h"

namespace surfit {

// Parameter block of a depth camera calibration: [fx fy cx cy c0 .. c5 T]. Intrinsics in px,
// coefficients of InverseDepthField in 1/m, readout time T of a rolling shutter in s.
inline constexpr int kFieldBegin = 4;
inline constexpr int kReadout = kFieldBegin + static_cast<int>(InverseDepthField::kSize);
inline constexpr int kCalibrationSize = kReadout + 1;

// Camera motion at an image row, in the camera frame. A row is read s T after the middle of the
// readout, with s in [-1/2, 1/2] and the readout time T.
struct RowMotion {
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();  // s times the angular velocity, rad/s
  Eigen::Vector3d way = Eigen::Vector3d::Zero();   // s times the linear velocity, m/s
  double readout_s = 0;                            // T of the applied CorrectRollingShutter()
};

// r = (1/z_measured + c(x, y) - 1/z_plane) / sigma, one row: corrected inverse depth of a pixel
// minus the inverse depth of a surfel plane. The plane has the unit normal n, the point p in the
// world, and the displacement d along n. With (R, t) = world_from_camera and e = ((u - cx)/fx,
// (v - cy)/fy, 1),
//   1/z_plane = n . R e / (n . (p - t) + d).
// If the readout time is longer by dT than `RowMotion::readout_s`, the measured point X moves to
// X + dT (turn x X + way). Then e + dT turn x e replaces e, and t + dT R way replaces t. The
// residual is in inverse depth, so that sigma does not depend on the calibration. A residual in
// m would favour calibrations with small depths. The residual is not finite if the plane contains
// the camera centre.
class PlaneInverseDepth {
 public:
  // Pixel (u, v) of the image after CorrectRollingShutter(), px. Its inverse depth is measured,
  // without the correction c, in 1/m. sigma: standard deviation of the inverse depth, 1/m,
  // positive. Point in m, unit normal.
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

  // Pose block (pose.h) at the middle of the readout, calibration block, displacement d in m.
  // Further values of a displacement block are not used.
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
