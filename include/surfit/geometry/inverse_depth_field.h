#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

#include "surfit/geometry/pinhole_camera.h"

namespace surfit {

// Additive correction of the measured inverse depth, 1/m, for the pixel with the ray (x, y, 1):
//   1/z = 1/z_measured + c0 + c1 x + c2 y + c3 x^2 + c4 x y + c5 y^2.
// The model fits triangulating sensors, whose errors are disparity errors: disparity is
// proportional to inverse depth.
struct InverseDepthField {
  static constexpr std::size_t kSize = 6;
  static constexpr double kMinInverse = 1e-3;  // 1/m; a corrected depth of 1 km or more is missing

  std::array<double, kSize> coefficients = {};

  // Basis functions of the coefficients, in their order. T: a scalar or ceres::Jet.
  template <typename T>
  static std::array<T, kSize> Basis(const T& x, const T& y) {
    return {T(1), x, y, x * x, x * y, y * y};
  }

  // Correction at the ray (x, y, 1), 1/m.
  double At(double x, double y) const {
    const std::array<double, kSize> basis = Basis(x, y);
    double sum = 0;
    for (std::size_t i = 0; i < kSize; ++i) sum += coefficients[i] * basis[i];
    return sum;
  }

  // Corrected depth in m of a measured depth in m at the ray (x, y, 1). 0 if the measured depth is
  // missing (0, negative or NaN), or if the corrected inverse depth is at most kMinInverse.
  float Corrected(float measured_m, double x, double y) const {
    if (!(measured_m > 0)) return 0;
    const double inverse = 1. / measured_m + At(x, y);
    return inverse > kMinInverse ? static_cast<float>(1 / inverse) : 0;
  }

  // The same field for another camera with the same pixels. The ray (x', y') of that camera is the
  // ray (x_scale x' + x_shift, y_scale y' + y_shift) of this camera.
  InverseDepthField Substituted(double x_scale, double x_shift, double y_scale,
                                double y_shift) const {
    const auto& [c0, c1, c2, c3, c4, c5] = coefficients;
    return {{At(x_shift, y_shift), x_scale * (c1 + 2 * c3 * x_shift + c4 * y_shift),
             y_scale * (c2 + c4 * x_shift + 2 * c5 * y_shift), x_scale * x_scale * c3,
             x_scale * y_scale * c4, y_scale * y_scale * c5}};
  }

  bool IsZero() const {
    for (const double c : coefficients) {
      if (c != 0) return false;
    }
    return true;
  }
};

// Calibration of an undistorted depth camera, estimated from its images.
struct DepthCalibration {
  PinholeCamera camera;     // size, fx, fy, cx, cy in px; no distortion
  InverseDepthField field;  // as a function of the rays of `camera`
  double readout_s = 0;     // RgbdCamera::readout_s
};

// Exact comparison of all parameters except image size and distortion.
inline bool AreSame(const DepthCalibration& a, const DepthCalibration& b) {
  return a.camera.fx == b.camera.fx && a.camera.fy == b.camera.fy && a.camera.cx == b.camera.cx &&
         a.camera.cy == b.camera.cy && a.field.coefficients == b.field.coefficients &&
         a.readout_s == b.readout_s;
}

// Converts a point in the camera frame, m, from one calibration to another. Its pixel and its
// measured depth do not change. Requires point.z() > 0. The depth is not limited: it is negative or
// infinite if the corrected inverse depth is negative or 0.
inline Eigen::Vector3d Recalibrated(const Eigen::Vector3d& point, const DepthCalibration& from,
                                    const DepthCalibration& to) {
  const Eigen::Vector2d pixel = from.camera.Project(point);
  const Eigen::Vector3d ray = to.camera.Ray(pixel.x(), pixel.y());
  const double inverse =
      1 / point.z() - from.field.At(point.x() / point.z(), point.y() / point.z());
  return ray / (inverse + to.field.At(ray.x(), ray.y()));
}

// Field of the mirrored camera (see Mirrored() in sensor.h). Its ray (x, y) is the ray (x, -y) of
// the original camera.
inline InverseDepthField Mirrored(const InverseDepthField& field) {
  return field.Substituted(1, 0, -1, 0);
}

}  // namespace surfit
