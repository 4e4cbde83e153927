#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

#include "surfit/geometry/pinhole_camera.h"

namespace surfit {

// What is to be added to the measured inverse depth of a pixel, in 1/m:
//   1/z = 1/z_measured + c0 + c1 x + c2 y + c3 x^2 + c4 x y + c5 y^2,
// (x, y, 1) the pixel's ray. The first coefficient is an offset, the same everywhere; the others
// bend the image smoothly. Errors of triangulating sensors are of this kind: their noise and their
// errors of calibration are errors of the disparity, which is proportional to inverse depth.
struct InverseDepthField {
  static constexpr std::size_t kSize = 6;
  static constexpr double kLeastInverse =
      1e-3;  // 1/m: what comes to lie beyond a kilometre is missing

  std::array<double, kSize> coefficients = {};

  // The factors of the coefficients. T is any number.
  template <typename T>
  static std::array<T, kSize> Basis(const T& x, const T& y) {
    return {T(1), x, y, x * x, x * y, y * y};
  }

  double At(double x, double y) const {
    const std::array<double, kSize> basis = Basis(x, y);
    double sum = 0;
    for (std::size_t i = 0; i < kSize; ++i) sum += coefficients[i] * basis[i];
    return sum;
  }

  // The depth for a measured one at the ray (x, y, 1), in metres; 0 where that is missing (0) or
  // would have no finite positive depth.
  float Corrected(float measured_m, double x, double y) const {
    if (!(measured_m > 0)) return 0;
    const double inverse = 1. / measured_m + At(x, y);
    return inverse > kLeastInverse ? static_cast<float>(1 / inverse) : 0;
  }

  // The same field by the rays of another camera of the same pixels, whose (x, y) are
  // (x_scale x + x_shift, y_scale y + y_shift) of those of this one's.
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

// What self-calibration may change of an undistorted depth camera.
struct DepthCalibration {
  PinholeCamera camera;     // size in px, fx fy cx cy; no distortion
  InverseDepthField field;  // by the rays of this camera
  double readout_s = 0;     // of a rolling shutter: RgbdCamera
};

inline bool AreSame(const DepthCalibration& a, const DepthCalibration& b) {
  return a.camera.fx == b.camera.fx && a.camera.fy == b.camera.fy && a.camera.cx == b.camera.cx &&
         a.camera.cy == b.camera.cy && a.field.coefficients == b.field.coefficients &&
         a.readout_s == b.readout_s;
}

// Where a point in the camera's frame, in metres, that was measured by one calibration lies by
// another one: its pixel and its measured depth are the same.
inline Eigen::Vector3d Recalibrated(const Eigen::Vector3d& point, const DepthCalibration& from,
                                    const DepthCalibration& to) {
  const Eigen::Vector2d pixel = from.camera.Project(point);
  const Eigen::Vector3d ray = to.camera.Ray(pixel.x(), pixel.y());
  const double inverse =
      1 / point.z() - from.field.At(point.x() / point.z(), point.y() / point.z());
  return ray / (inverse + to.field.At(ray.x(), ray.y()));
}

// The same before points mirrored by S (mirror.h): at the ray (x, -y).
inline InverseDepthField Mirrored(const InverseDepthField& field) {
  return field.Substituted(1, 0, -1, 0);
}

}  // namespace surfit
