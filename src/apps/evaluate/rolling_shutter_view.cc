#include "apps/evaluate/rolling_shutter_view.h"

#include <algorithm>
#include <cmath>

#include "surfit/core/parallel.h"

namespace surfit {
namespace {

// Number of fixed-point iterations. The displacement depends on the depth at the unknown source
// pixel.
constexpr int kPasses = 3;

struct PixelPosition {
  double u, v;
};

class RollingShutterSampler {
 public:
  RollingShutterSampler(const BlendedView& view, const PinholeCamera& camera,
                        const CameraMotion& motion)
      : view_(view), camera_(camera), motion_(motion) {}

  // Source position in the view of the scene point that reaches pixel (u, v) at time t, s. The view
  // shows time 0.
  PixelPosition OriginOf(int u, int v, double t) const {
    PixelPosition at = {1. * u, 1. * v};
    for (int pass = 0; pass < kPasses; ++pass) {
      const int near_u = Nearest(at.u, camera_.width), near_v = Nearest(at.v, camera_.height);
      const double z = view_.depth_m(near_u, near_v);
      // A pixel without depth is infinitely far away: only the rotation moves it.
      const Eigen::Vector3d ray = camera_.Ray(near_u, near_v), x = (z > 0 ? z : 1) * ray;
      const Eigen::Vector3d way = motion_.angular_velocity_rad_per_s.cross(x) +
                                  (z > 0 ? 1. : 0.) * motion_.velocity_m_per_s;
      const Eigen::Vector3d moved = x - t * way;
      at.u = u - (camera_.fx * moved.x() / moved.z() + camera_.cx - near_u);
      at.v = v - (camera_.fy * moved.y() / moved.z() + camera_.cy - near_v);
    }
    return at;
  }

  Rgb8 ColorAt(PixelPosition at) const {
    const int left = static_cast<int>(std::floor(at.u)), top = static_cast<int>(std::floor(at.v));
    double sum[3] = {}, weights = 0;
    for (int k = 0; k < 4; ++k) {
      const int u = left + k % 2, v = top + k / 2;
      if (u < 0 || v < 0 || u >= camera_.width || v >= camera_.height) continue;
      if (!(view_.depth_m(u, v) > 0)) continue;
      const double weight = (1 - std::abs(at.u - u)) * (1 - std::abs(at.v - v));
      const Rgb8 color = view_.color(u, v);
      sum[0] += weight * color.r, sum[1] += weight * color.g, sum[2] += weight * color.b;
      weights += weight;
    }
    if (weights == 0) return {};
    const auto byte = [&](double value) {
      return static_cast<std::uint8_t>(value / weights + 0.5);
    };
    return {byte(sum[0]), byte(sum[1]), byte(sum[2])};
  }

  float DepthAt(PixelPosition at) const {
    const double u = std::floor(at.u + 0.5), v = std::floor(at.v + 0.5);
    if (!(u >= 0 && v >= 0 && u < camera_.width && v < camera_.height)) return 0;
    return view_.depth_m(static_cast<int>(u), static_cast<int>(v));
  }

 private:
  static int Nearest(double at, int size) {
    return static_cast<int>(std::clamp(std::floor(at + 0.5), 0., size - 1.));
  }

  const BlendedView& view_;
  const PinholeCamera camera_;
  const CameraMotion& motion_;
};

}  // namespace

PinholeCamera WithRollMargin(PinholeCamera camera) {
  camera.width += 2 * kRollMargin_px;
  camera.height += 2 * kRollMargin_px;
  camera.cx += kRollMargin_px;
  camera.cy += kRollMargin_px;
  return camera;
}

BlendedView Rolled(const BlendedView& with_margin, const PinholeCamera& camera,
                   const CameraMotion& motion, const RowTimes& times) {
  BlendedView rolled = {Image<Rgb8>(camera.width, camera.height),
                        Image<float>(camera.width, camera.height)};
  const RollingShutterSampler roller(with_margin, WithRollMargin(camera), motion);
  ParallelFor(0, camera.height, kRowsPerBlock, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      const double t = times.middle_s + ((v + 0.5) / camera.height - 0.5) * times.readout_s;
      for (int u = 0; u < camera.width; ++u) {
        const PixelPosition at = roller.OriginOf(u + kRollMargin_px, v + kRollMargin_px, t);
        rolled.depth_m(u, v) = roller.DepthAt(at);
        if (rolled.depth_m(u, v) > 0) rolled.color(u, v) = roller.ColorAt(at);
      }
    }
  });
  return rolled;
}

}  // namespace surfit
