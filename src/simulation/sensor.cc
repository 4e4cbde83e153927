#include <Eigen/Geometry>
#include <cmath>

#include "simulation/random.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/core/parallel.h"
#include "surfit/simulation/render.h"

namespace surfit {
namespace {

// Depth at (u, v) by bilinear interpolation of inverse depth, which is exact on planes. Returns
// `here` at the image border, or if one of the four neighbours is on another surface.
double ShiftedDepth(const Image<float>& depth_m, double u, double v, double here,
                    double max_edge_ratio) {
  const int u0 = static_cast<int>(std::floor(u)), v0 = static_cast<int>(std::floor(v));
  if (u0 < 0 || v0 < 0 || u0 + 1 >= depth_m.width() || v0 + 1 >= depth_m.height()) return here;
  double disparity[2][2];
  for (int j = 0; j < 2; ++j) {
    for (int i = 0; i < 2; ++i) {
      const double depth = depth_m(u0 + i, v0 + j);
      if (!(std::abs(depth - here) <= max_edge_ratio * here)) return here;
      disparity[j][i] = 1 / depth;
    }
  }
  const double a = u - u0, b = v - v0;
  return 1 / ((1 - b) * ((1 - a) * disparity[0][0] + a * disparity[0][1]) +
              b * ((1 - a) * disparity[1][0] + a * disparity[1][1]));
}

double CosineOfIncidence(const Image<float>& depth_m, const PinholeCamera& camera, int u, int v) {
  // Point at pixel (other_u, other_v). If this pixel has no depth, the point at (u, v).
  const auto point = [&](int other_u, int other_v) -> Eigen::Vector3d {
    const bool inside = other_u >= 0 && other_v >= 0 && other_u < depth_m.width() &&
                        other_v < depth_m.height() && depth_m(other_u, other_v) > 0;
    if (!inside) return depth_m(u, v) * camera.Ray(u, v);
    return depth_m(other_u, other_v) * camera.Ray(other_u, other_v);
  };
  const Eigen::Vector3d normal =
      (point(u + 1, v) - point(u - 1, v)).cross(point(u, v + 1) - point(u, v - 1));
  const Eigen::Vector3d ray = camera.Ray(u, v);
  return std::abs(normal.dot(ray)) / (normal.norm() * ray.norm());
}

double Quantised(double depth_m, double disparity_noise, const KinectOptions& options) {
  constexpr double kCmPerMetre = 100;
  const double constant_m = options.disparity_times_z_cm / kCmPerMetre;
  return constant_m / std::round(constant_m / depth_m + disparity_noise);
}

}  // namespace

Image<float> KinectDepth(const Image<float>& depth_m, const PinholeCamera& camera,
                         std::uint64_t seed, const KinectOptions& options) {
  Validate(options);
  ThrowIf(depth_m.width() != camera.width || depth_m.height() != camera.height,
          "the depth image has ", depth_m.width(), " x ", depth_m.height(), " pixels, must have ",
          camera.width, " x ", camera.height, " like its camera");
  const double min_cosine = std::cos(options.max_incidence_deg * M_PI / 180);
  Image<float> measured(depth_m.width(), depth_m.height(), 0.f);
  ParallelFor(0, depth_m.height(), 16, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      Random random(seed, v);
      for (int u = 0; u < depth_m.width(); ++u) {
        const double shift_u = options.shift_sd_px * random.Normal();
        const double shift_v = options.shift_sd_px * random.Normal();
        const double disparity_noise = options.disparity_sd * random.Normal();
        const double here = depth_m(u, v);
        if (here <= 0) continue;
        if (!(CosineOfIncidence(depth_m, camera, u, v) > min_cosine)) continue;
        const double shifted =
            ShiftedDepth(depth_m, u + shift_u, v + shift_v, here, options.max_edge_ratio);
        const double z = Quantised(shifted, disparity_noise, options);
        if (z < options.min_depth_m || z > options.max_depth_m) continue;
        measured(u, v) = static_cast<float>(z);
      }
    }
  });
  return measured;
}

}  // namespace surfit
