#include "apps/export/color_lens.h"

#include <Eigen/LU>
#include <algorithm>

#include "surfit/core/parallel.h"
#include "surfit/mapping/surfel_block.h"

namespace surfit {

std::optional<LensPoint> ProjectByLens(const PinholeCamera& camera, const Eigen::Vector3d& point) {
  if (!(point.z() > 0)) return {};
  const auto& [k1, k2, p1, p2, k3] = camera.distortion;
  const double rho = 1 / point.z(), x = point.x() * rho, y = point.y() * rho;
  const double r2 = x * x + y * y, k = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  if (!(1 + r2 * (3 * k1 + r2 * (5 * k2 + r2 * 7 * k3)) > 0)) return {};
  const double by_r2 = k1 + r2 * (2 * k2 + r2 * 3 * k3);
  LensPoint result;
  result.distorted = {x * k + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
                      y * k + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y};
  result.pixel = {camera.fx * result.distorted.x() + camera.cx,
                  camera.fy * result.distorted.y() + camera.cy};
  Eigen::Matrix2d by_xy;
  by_xy << k + 2 * x * x * by_r2 + 2 * p1 * y + 6 * p2 * x,
      2 * x * y * by_r2 + 2 * p1 * x + 2 * p2 * y, 2 * x * y * by_r2 + 2 * p1 * x + 2 * p2 * y,
      k + 2 * y * y * by_r2 + 6 * p1 * y + 2 * p2 * x;
  Eigen::Matrix<double, 2, 3> xy_by_point;
  xy_by_point << rho, 0, -x * rho, 0, rho, -y * rho;
  by_xy.row(0) *= camera.fx;
  by_xy.row(1) *= camera.fy;
  result.by_point = by_xy * xy_by_point;
  return result;
}

std::optional<Eigen::Vector3d> RayOfLens(const PinholeCamera& camera, double u, double v) {
  constexpr int kMaxSteps = 20;
  constexpr double kTolerance_px = 1e-6;
  Eigen::Vector3d ray = camera.Ray(u, v);
  if (!camera.HasDistortion()) return ray;
  for (int i = 0; i < kMaxSteps; ++i) {
    const std::optional<LensPoint> seen = ProjectByLens(camera, ray);
    if (!seen) return {};
    const Eigen::Vector2d error = seen->pixel - Eigen::Vector2d(u, v);
    if (error.norm() < kTolerance_px) return ray;
    ray.head<2>() -= seen->by_point.leftCols<2>().inverse() * error;
  }
  return {};
}

PinholeCamera UndistortedCamera(const PinholeCamera& camera) {
  PinholeCamera undistorted = camera;
  undistorted.distortion = {};
  if (!camera.HasDistortion()) return undistorted;
  const auto is_filled = [&](double zoom) {
    PinholeCamera zoomed = undistorted;
    zoomed.fx *= zoom;
    zoomed.fy *= zoom;
    for (int v = 0; v < camera.height; ++v) {
      const bool is_border_row = v == 0 || v == camera.height - 1;
      for (int u = 0; u < camera.width; u += is_border_row ? 1 : camera.width - 1) {
        const std::optional<LensPoint> seen = ProjectByLens(camera, zoomed.Ray(u, v));
        if (!seen || !IsInside(camera, seen->pixel, 0)) return false;
      }
    }
    return true;
  };
  constexpr double kMaxZoom = 4, kPrecision = 1e-4;
  double low = 0.8, high = kMaxZoom;
  while (high - low > kPrecision) {
    const double middle = 0.5 * (low + high);
    (is_filled(middle) ? high : low) = middle;
  }
  undistorted.fx *= high;
  undistorted.fy *= high;
  return undistorted;
}

Image<Rgb8> Undistort(const Image<Rgb8>& image, const PinholeCamera& camera,
                      const PinholeCamera& undistorted) {
  Image<Rgb8> result(undistorted.width, undistorted.height);
  ParallelFor(0, undistorted.height, kRowsPerBlock, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      for (int u = 0; u < undistorted.width; ++u) {
        const std::optional<LensPoint> seen = ProjectByLens(camera, undistorted.Ray(u, v));
        if (!seen || !IsInside(camera, seen->pixel, 0)) continue;
        const int left = std::min(static_cast<int>(seen->pixel.x()), image.width() - 2);
        const int top = std::min(static_cast<int>(seen->pixel.y()), image.height() - 2);
        const float a = static_cast<float>(seen->pixel.x()) - static_cast<float>(left);
        const float b = static_cast<float>(seen->pixel.y()) - static_cast<float>(top);
        const auto at = [&](int du, int dv) {
          const Rgb8 c = image(left + du, top + dv);
          return Eigen::Vector3f(c.r, c.g, c.b);
        };
        result(u, v) = ToRgb8((1 - b) * ((1 - a) * at(0, 0) + a * at(1, 0)) +
                              b * ((1 - a) * at(0, 1) + a * at(1, 1)));
      }
    }
  });
  return result;
}

}  // namespace surfit
