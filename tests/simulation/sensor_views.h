#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "surfit/simulation/render.h"
#include "testing/pixels.h"

namespace surfit::testing {

constexpr Rgb8 kWhite = {255, 255, 255};  // reflectance 1

inline PinholeCamera SensorCamera() { return {320, 240, 262.5, 262.5, 159.5, 119.5, {}}; }

struct SurfacePoint {
  double z = 0;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  Rgb8 color = kWhite;
};

// Rendering of a surface that is given per pixel.
inline Rendering ViewOf(const PinholeCamera& camera,
                        const std::function<SurfacePoint(int u, int v)>& surface) {
  Rendering view;
  view.depth_m = Image<float>(camera.width, camera.height);
  view.color = Image<Rgb8>(camera.width, camera.height);
  view.normal = VectorImage(camera.width, camera.height);
  for (const auto [u, v] : PixelsOf(camera)) {
    const SurfacePoint point = surface(u, v);
    view.depth_m(u, v) = static_cast<float>(point.z);
    view.color(u, v) = point.color;
    view.normal.Set(u, v, point.normal.cast<float>());
  }
  return view;
}

// Plane at depth z on the optical axis. Depth is 0 for rays that miss the plane. The normal is
// turned by `slant_rad` about the y axis.
inline Rendering PlaneView(const PinholeCamera& camera, double z, double slant_rad = 0,
                           const std::function<Rgb8(int u, int v)>& color = {}) {
  const Eigen::Vector3d normal(std::sin(slant_rad), 0, -std::cos(slant_rad));
  return ViewOf(camera, [&](int u, int v) -> SurfacePoint {
    const double depth = z * normal.z() / normal.dot(camera.Ray(u, v));
    return {std::max(0., depth), normal, color ? color(u, v) : kWhite};
  });
}

// Squares with much contrast in every window.
inline Rgb8 Squares(int u, int v) {
  return (u / 2 + v / 2) % 2 == 0 ? kWhite : Rgb8{128, 128, 128};
}

// Frontal plane at `near_m` in the columns [begin, end), in front of a frontal plane at `far_m`.
inline Rendering StepView(const PinholeCamera& camera, double near_m, double far_m, int begin,
                          int end, Rgb8 near_color = kWhite, Rgb8 far_color = kWhite) {
  return ViewOf(camera, [&](int u, int) -> SurfacePoint {
    const bool is_near = u >= begin && u < end;
    return {is_near ? near_m : far_m, -Eigen::Vector3d::UnitZ(), is_near ? near_color : far_color};
  });
}

// Two walls at right angles, both at 45 degrees to the optical axis. They meet at x = 0 and depth
// z. `concave`: the meeting line is the farthest part. Otherwise it is the nearest part.
inline Rendering CornerView(const PinholeCamera& camera, double z, bool concave,
                            Rgb8 color = kWhite) {
  return ViewOf(camera, [&](int u, int v) -> SurfacePoint {
    const double x = camera.Ray(u, v).x(), sign = concave ? 1 : -1, side = x > 0 ? 1 : -1;
    return {z / (1 + sign * std::abs(x)), Eigen::Vector3d(-sign * side, 0, -1) / std::sqrt(2.),
            color};
  });
}

// Mean and standard deviation.
struct Spread {
  double mean = 0, sd = 0;
  int count = 0;
};

inline Spread SpreadOf(const std::vector<double>& values) {
  Spread spread;
  spread.count = static_cast<int>(values.size());
  for (const double value : values) spread.mean += value / spread.count;
  for (const double value : values) spread.sd += std::pow(value - spread.mean, 2) / spread.count;
  spread.sd = std::sqrt(spread.sd);
  return spread;
}

// Errors of the inverse depth of all measured pixels.
inline std::vector<double> InverseDepthErrors(const Rendering& exact, const SensorImage& measured) {
  std::vector<double> errors;
  for (std::size_t i = 0; i < exact.depth_m.size(); ++i) {
    if (measured.depth_m[i] == 0) continue;
    errors.push_back(1. / measured.depth_m[i] - 1. / exact.depth_m[i]);
  }
  return errors;
}

inline double MissingRatio(const SensorImage& image) {
  const auto missing = std::count(image.depth_m.begin(), image.depth_m.end(), 0.f);
  return static_cast<double>(missing) / static_cast<double>(image.depth_m.size());
}

}  // namespace surfit::testing
