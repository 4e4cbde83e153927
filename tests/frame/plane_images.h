#pragma once

#include <cmath>
#include <vector>

#include "surfit/core/image.h"
#include "surfit/geometry/pinhole_camera.h"
#include "testing/pixels.h"

namespace surfit::testing {

// Relative rounding of one float operation.
constexpr double kFloatRounding = 1.0 / (1 << 24);

// Small camera without round or equal parameters: 74 x 62 deg.
inline PinholeCamera SmallCamera() { return {96, 72, 63.7, 60.3, 48.3, 35.1, {}}; }

// Length of the ray at depth 1 through the farthest corner of SmallCamera().
constexpr double kLongestRay = 1.42;

// Plane normal . X = distance_m. Negative: the normal faces the camera.
struct Plane {
  Eigen::Vector3d normal = -Eigen::Vector3d::UnitZ();
  double distance_m = -1.5;

  // 1 / z at the intersection of ray and plane: normal . ray / distance, linear in the pixel.
  double InverseDepth(const Eigen::Vector3d& ray) const { return normal.dot(ray) / distance_m; }
  // Angle between the ray and the normal of the surface.
  double Slant(const Eigen::Vector3d& ray) const {
    return std::acos(std::abs(normal.dot(ray)) / ray.norm());
  }
};

// Plane with a normal that is tilted from the optical axis by `tilt_rad`, towards the direction
// `azimuth_rad` in the image.
inline Plane TiltedPlane(double tilt_rad, double azimuth_rad) {
  const double s = std::sin(tilt_rad);
  return {{s * std::cos(azimuth_rad), s * std::sin(azimuth_rad), -std::cos(tilt_rad)}, -1.5};
}

// Planes of many tilts and directions, from facing the camera to steep.
inline std::vector<Plane> ManyPlanes() {
  std::vector<Plane> planes = {Plane()};
  for (const double tilt_rad : {0.2, 0.6, 1.0, 1.25}) {
    for (int i = 0; i < 8; ++i) planes.push_back(TiltedPlane(tilt_rad, 0.1 + i * M_PI / 4));
  }
  return planes;
}

// Exact depth of the plane, rounded to float. 0: not in front of the camera.
inline Image<float> PlaneDepth(const Plane& plane, const PinholeCamera& camera) {
  Image<float> depth_m(camera.width, camera.height);
  for (const auto [u, v] : PixelsOf(camera)) {
    const double inverse = plane.InverseDepth(camera.Ray(u, v));
    depth_m(u, v) = inverse > 0.02 ? static_cast<float>(1 / inverse) : 0.f;
  }
  return depth_m;
}

}  // namespace surfit::testing
