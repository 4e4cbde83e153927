#pragma once

#include <array>

#include "cost_functions/plane_inverse_depth.h"
#include "cost_functions/pose.h"

namespace surfit {

// Linearised image at the pixel (u, v).
struct IntensityTap {
  float u = 0, v = 0;              // px
  float value = 0;                 // intensity
  float slope_u = 0, slope_v = 0;  // per px
};

using TextureTaps = std::array<IntensityTap, 3>;

// Texture residual of a surfel in a keyframe (after Schoeps, Sattler and Pollefeys, BAD SLAM, CVPR
// 2019). Two rows r_j = ((I(q_j) - I(q_0)) - a_j) / sigma for j = 1, 2: measured minus expected
// intensity difference between a point beside the surfel and its centre. Brightness offsets cancel.
//
// The points p_0 (centre), p_1 and p_2 are displaced by d (m) along the normal n of the surfel. The
// calibration block is that of plane_inverse_depth.h; only fx, fy, cx and cy are used. With (R, t)
// = world_from_camera,
//   (x, y, z) = R^T (p_j + d n - t),  q_j = (fx x / z + cx, fy y / z + cy).
// I is the keyframe image, linearised at the taps. The residuals are not finite if a z is 0.
class SurfelTexture {
 public:
  // Intensities and sigma have the same unit. Points in m.
  SurfelTexture(const TextureTaps& taps, double sigma,
                const std::array<Eigen::Vector3d, 3>& points_in_world,
                const Eigen::Vector3d& normal_in_world)
      : taps_(taps),
        inverse_sigma_(1 / sigma),
        points_(points_in_world),
        normal_(normal_in_world) {}

  // Pose block (pose.h), calibration block, displacement in m, texture [a_1 a_2].
  template <typename T>
  bool operator()(const T* pose, const T* calibration, const T* displacement, const T* texture,
                  T* residuals) const {
    const T center = Intensity(0, pose, calibration, displacement[0]);
    for (int j = 0; j < 2; ++j) {
      const T beside = Intensity(j + 1, pose, calibration, displacement[0]);
      residuals[j] = (beside - center - texture[j]) * inverse_sigma_;
    }
    return true;
  }
  // Surfel parameters as one block [d a_1 a_2], for the Schur complement.
  template <typename T>
  bool operator()(const T* pose, const T* calibration, const T* numbers, T* residuals) const {
    return (*this)(pose, calibration, numbers, numbers + 1, residuals);
  }

 private:
  template <typename T>
  T Intensity(int j, const T* pose, const T* calibration, const T& displacement) const {
    const T inverse[4] = {-pose[0], -pose[1], -pose[2], pose[3]};
    T from_camera[3], p[3];
    for (int i = 0; i < 3; ++i) {
      from_camera[i] = displacement * normal_[i] + points_[j][i] - pose[4 + i];
    }
    RotateByPose(inverse, from_camera, p);
    const IntensityTap& tap = taps_[j];
    const T du = calibration[0] * p[0] / p[2] + calibration[2] - double{tap.u};
    const T dv = calibration[1] * p[1] / p[2] + calibration[3] - double{tap.v};
    return du * double{tap.slope_u} + dv * double{tap.slope_v} + double{tap.value};
  }

  TextureTaps taps_;
  double inverse_sigma_;
  std::array<Eigen::Vector3d, 3> points_;
  Eigen::Vector3d normal_;
};

}  // namespace surfit
