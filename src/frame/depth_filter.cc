#include <algorithm>
#include <cstdlib>
#include <vector>

#include "surfit/core/parallel.h"
#include "surfit/frame/preprocess.h"

namespace surfit {
namespace {

constexpr int kRowsPerBlock = 16;

// Inverse depth with a margin of missing pixels on all sides, so that no tap leaves the image.
Image<float> PaddedInverseDepth(const Image<float>& depth_m, int margin) {
  Image<float> inverse(depth_m.width() + 2 * margin, depth_m.height() + 2 * margin, 0.f);
  ParallelFor(0, depth_m.height(), kRowsPerBlock, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      const float* in = depth_m.row(v);
      float* out = inverse.row(v + margin) + margin;
      for (int u = 0; u < depth_m.width(); ++u) out[u] = in[u] > 0 ? 1.f / in[u] : 0.f;
    }
  });
  return inverse;
}

// Adds one tap of the window to the weighted sums of differences from the row's own pixels.
void AddTap(const float* center, const float* tap, float space_weight, float inverse_cutoff2,
            int width, float* sum, float* weight_sum) {
  for (int u = 0; u < width; ++u) {
    const float difference = tap[u] - center[u];
    float weight = std::max(0.f, 1.f - difference * difference * inverse_cutoff2);
    weight = tap[u] > 0 ? weight * weight * space_weight : 0.f;
    sum[u] += weight * difference;
    weight_sum[u] += weight;
  }
}

}  // namespace

Image<float> FilterDepth(const Image<float>& depth_m, const PreprocessOptions& options) {
  const int radius = options.filter_radius_px;
  if (radius == 0 || depth_m.empty()) return depth_m;
  const int width = depth_m.width();
  const Image<float> inverse = PaddedInverseDepth(depth_m, radius);
  const double cutoff = options.filter_cutoff * options.noise.inverse_depth_sigma;
  const float inverse_cutoff2 = static_cast<float>(1 / (cutoff * cutoff));
  Image<float> filtered(width, depth_m.height());
  ParallelFor(0, depth_m.height(), kRowsPerBlock, [&](int begin, int end) {
    std::vector<float> sum(width), weight_sum(width);
    for (int v = begin; v < end; ++v) {
      std::fill(sum.begin(), sum.end(), 0.f);
      std::fill(weight_sum.begin(), weight_sum.end(), 0.f);
      const float* center = inverse.row(v + radius) + radius;
      for (int dv = -radius; dv <= radius; ++dv) {
        for (int du = -radius; du <= radius; ++du) {
          const float space_weight =
              static_cast<float>((radius + 1 - std::abs(dv)) * (radius + 1 - std::abs(du)));
          AddTap(center, inverse.row(v + radius + dv) + radius + du, space_weight, inverse_cutoff2,
                 width, sum.data(), weight_sum.data());
        }
      }
      float* out = filtered.row(v);
      for (int u = 0; u < width; ++u) {
        out[u] = center[u] > 0 ? 1.f / (center[u] + sum[u] / weight_sum[u]) : 0.f;
      }
    }
  });
  return filtered;
}

}  // namespace surfit
