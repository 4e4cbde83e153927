#include <cstdlib>
#include <vector>

#include "frame/inverse_depth_band.h"
#include "surfit/core/lanes.h"
#include "surfit/core/parallel.h"
#include "surfit/frame/preprocess.h"

namespace surfit {
namespace {

// Weights of the window, row by row. Each weight fills all lanes, so that it needs no broadcast.
std::vector<float> TriangleWeights(int radius) {
  std::vector<float> weights;
  for (int dv = -radius; dv <= radius; ++dv) {
    for (int du = -radius; du <= radius; ++du) {
      weights.insert(weights.end(), Lanes<float>::kCount,
                     static_cast<float>((radius + 1 - std::abs(dv)) * (radius + 1 - std::abs(du))));
    }
  }
  return weights;
}

// Returns the filtered inverse depth, divided by the cut-off. The sums contain differences to the
// centre pixel, because sums of values would lose precision. Radius: int or a constant.
template <typename V, typename Radius>
V FilteredInverse(const float* at, std::ptrdiff_t stride, Radius radius, const float* weights) {
  const V center = V::Load(at);
  V sum, weight_sum;
  for (int dv = -radius; dv <= radius; ++dv) {
    const float* tap = at + dv * stride - radius;
    for (int i = 0; i <= 2 * radius; ++i, weights += V::kCount) {
      const V difference = V::Load(tap + i) - center;
      const V share = Max(1. - difference * difference, 0.);
      const V weight = share * share * V::Load(weights);
      sum += weight * difference;
      weight_sum += weight;
    }
  }
  return center + sum / weight_sum;
}

template <typename V, typename Radius>
void FilterRow(const InverseDepthBand& band, int v, int width, Radius radius, const float* weights,
               float scale, float* depth_m) {
  const float* const row = band.row(v);
  for (int u = 0; u < width; u += V::kCount) {
    const V filtered = FilteredInverse<V>(row + u, band.stride(), radius, weights);
    Select(V::Load(row + u) > 0., V(scale) / filtered, 0.).StoreUpTo(depth_m + u, width - u);
  }
}

}  // namespace

Image<float> FilterDepth(const Image<float>& depth_m, const DepthNoise& noise,
                         const PreprocessOptions& options) {
  const int radius = options.filter_radius_px;
  if (radius == 0 || depth_m.empty()) return depth_m;
  const int width = depth_m.width(), height = depth_m.height();
  const double cutoff = options.filter_cutoff * noise.inverse_depth_sigma;
  const float scale = static_cast<float>(1 / cutoff);
  const std::vector<float> weights = TriangleWeights(radius);
  Image<float> filtered;
  filtered.Resize(width, height);
  ParallelFor(0, height, kRowsPerBlock, [&](int begin, int end) {
    InverseDepthBand band(width, end - begin, radius);
    WithInstructions([&](auto instructions) {
      using V = Lanes<float, decltype(instructions)>;
      band.Fill<V>(depth_m, begin, end, scale);
      WithConstant<PreprocessOptions().filter_radius_px>(radius, [&](auto constant) {
        for (int v = begin; v < end; ++v) {
          FilterRow<V>(band, v, width, constant, weights.data(), scale, filtered.row(v));
        }
      });
    });
  });
  return filtered;
}

}  // namespace surfit
