#pragma once

#include <Eigen/Core>
#include <optional>

#include "surfit/geometry/pinhole_camera.h"

namespace surfit {

// The pixel at which a camera with lens distortion sees a point. With x = X/Z, y = Y/Z, r2 = x^2 +
// y^2 and k = 1 + k1 r2 + k2 r2^2 + k3 r2^3 (Brown's model, as OpenCV's calibration has it):
//   u = fx (x k + 2 p1 x y + p2 (r2 + 2 x^2)) + cx,
//   v = fy (y k + p1 (r2 + 2 y^2) + 2 p2 x y) + cy.
// Nothing for points with Z <= 0, and nothing where r k falls with growing r: there the polynomial
// folds the outside of the picture back into it.
inline std::optional<Eigen::Vector2d> ProjectThroughLens(const PinholeCamera& camera,
                                                         const Eigen::Vector3d& point_in_camera) {
  if (!(point_in_camera.z() > 0)) return std::nullopt;
  const auto& [k1, k2, p1, p2, k3] = camera.distortion;
  const double x = point_in_camera.x() / point_in_camera.z();
  const double y = point_in_camera.y() / point_in_camera.z();
  const double r2 = x * x + y * y;
  if (1 + r2 * (3 * k1 + r2 * (5 * k2 + r2 * 7 * k3)) <= 0) return std::nullopt;
  const double k = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  return Eigen::Vector2d(camera.fx * (x * k + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)) + camera.cx,
                         camera.fy * (y * k + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y) + camera.cy);
}

// Whether a pixel position lies on a pixel of the camera's image.
inline bool IsInImage(const PinholeCamera& camera, const Eigen::Vector2d& pixel) {
  return pixel.x() >= -0.5 && pixel.y() >= -0.5 && pixel.x() < camera.width - 0.5 &&
         pixel.y() < camera.height - 0.5;
}

}  // namespace surfit
