#include "mapping/measured_points.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "surfit/core/parallel.h"

namespace surfit {
namespace {

constexpr int kRowsPerBlock = 16;

// The depth in front of which a pixel with this measured depth has seen free space.
float FreeDepth(float depth_m, const FusionOptions& options) {
  if (!(depth_m > 0)) return 0.f;
  const float sigma = static_cast<float>(options.noise.inverse_depth_sigma) * depth_m * depth_m;
  return std::max(0.f, depth_m - options.free_space_margin_m - 4.f * sigma);
}

// The minimum of FreeDepth over the 3 x 3 pixels around each one.
Image<float> FreeDepths(const Image<float>& depth_m, const FusionOptions& options) {
  const int width = depth_m.width(), height = depth_m.height();
  Image<float> along_rows(width, height), result(width, height);
  ParallelFor(0, height, kRowsPerBlock, [&](int begin, int end) {
    std::vector<float> own(width + 2, std::numeric_limits<float>::infinity());
    for (int v = begin; v < end; ++v) {
      for (int u = 0; u < width; ++u) own[u + 1] = FreeDepth(depth_m(u, v), options);
      float* out = along_rows.row(v);
      for (int u = 0; u < width; ++u) out[u] = std::min(std::min(own[u], own[u + 1]), own[u + 2]);
    }
  });
  ParallelFor(0, height, kRowsPerBlock, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      const float* above = along_rows.row(std::max(0, v - 1));
      const float* own = along_rows.row(v);
      const float* below = along_rows.row(std::min(height - 1, v + 1));
      float* out = result.row(v);
      for (int u = 0; u < width; ++u) out[u] = std::min(std::min(above[u], own[u]), below[u]);
    }
  });
  return result;
}

}  // namespace

void MeasurePoints(const RgbdFrame& frame, const FrameLevel& surface, const FusionOptions& options,
                   std::vector<MeasuredPoint>* points) {
  const int width = surface.camera.width, height = surface.camera.height;
  const float pixel_size = std::sqrt(2.f) / static_cast<float>(surface.camera.fx);
  const Image<float> free_depth = FreeDepths(frame.depth_m, options);
  points->resize(static_cast<std::size_t>(width) * height);
  ParallelFor(0, height, kRowsPerBlock, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      for (int u = 0; u < width; ++u) {
        MeasuredPoint& point = (*points)[static_cast<std::size_t>(v) * width + u];
        point.position = surface.vertex(u, v);
        point.normal = surface.normal(u, v);
        const float cosine = std::fabs(point.normal.z());
        const bool exists = point.position.z() > 0 && !point.normal.isZero(0.f);
        const float slant = std::min(1.f / std::max(cosine, 1e-6f), options.max_slant_scale);
        point.radius_m = exists ? pixel_size * point.position.z() * slant : 0.f;
        point.free_depth_m = free_depth(u, v);
      }
    }
  });
}

Image<float> PointWeights(const PinholeCamera& camera, const FusionOptions& options) {
  Image<float> weights(camera.width, camera.height, 1.f);
  if (options.weighting == "uniform") return weights;
  const double corner_u = std::max(camera.cx, camera.width - 1 - camera.cx);
  const double corner_v = std::max(camera.cy, camera.height - 1 - camera.cy);
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const double du = u - camera.cx, dv = v - camera.cy;
      const double g2 = (du * du + dv * dv) / (corner_u * corner_u + corner_v * corner_v);
      weights(u, v) = static_cast<float>(std::exp(-g2 / 0.72));
    }
  }
  return weights;
}

}  // namespace surfit
