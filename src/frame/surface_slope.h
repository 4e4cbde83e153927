#pragma once

#include <cmath>
#include <cstddef>

#include "surfit/frame/preprocess.h"
#include "surfit/geometry/sensor.h"

namespace surfit {

// Maximum change of inverse depth r (1/m) between neighbouring pixels of a surface; larger changes
// are depth edges. It is 3 sigma plus r tan(max_slant_rad) / f: the slope at the principal point of
// a surface whose normal has this angle to the viewing ray. A pixel has the bound noise + slant_u r
// along u, and the bound noise + slant_v r along v.
struct EdgeBounds {
  EdgeBounds(const DepthSensor& sensor, const PreprocessOptions& options)
      : noise(static_cast<float>(3 * sensor.noise.inverse_depth_sigma)) {
    const float tan_slant = static_cast<float>(std::tan(options.max_slant_rad));
    slant_u = tan_slant / static_cast<float>(sensor.camera.fx);
    slant_v = tan_slant / static_cast<float>(sensor.camera.fy);
  }

  float noise;
  float slant_u, slant_v;
};

// True, per lane, if the step from offset k - 1 to offset k is within `bound` on both sides. Offset
// k is k * stride values away. k >= 1. All lanes must be readable at +k and -k. Missing pixels must
// be InverseDepthBand::kMissing. A step between a valid and a missing pixel is never within the
// bound. A step between two missing pixels is 0.
template <typename V>
typename V::Mask Continues(const float* at, std::ptrdiff_t stride, int k, const V& bound) {
  const V ahead = V::Load(at + k * stride) - V::Load(at + (k - 1) * stride);
  const V behind = V::Load(at - k * stride) - V::Load(at - (k - 1) * stride);
  return Max(abs(ahead), abs(behind)) < bound;
}

template <typename V>
struct SurfaceSlope {
  V value;                 // 1/m per pixel; NaN if not valid
  typename V::Mask valid;  // false: depth edge at the nearest offset
};

// Least-squares slope of inverse depth r in one direction:
//   sum of k (r(+k) - r(-k)) / sum of 2 k^2
// over the offsets k from 1 to `radius` (at least 1), up to the first depth edge. `at` points to
// the inverse depth of the first lane, 1/m. All lanes must be readable at +radius and -radius.
// Radius: int or a constant.
template <typename V, typename Radius>
SurfaceSlope<V> SlopeAlong(const float* at, std::ptrdiff_t stride, Radius radius, const V& bound) {
  SurfaceSlope<V> slope;
  slope.valid = Continues(at, stride, 1, bound);
  typename V::Mask alive = slope.valid;
  V sum, norm;
  for (int k = 1; k <= radius; ++k) {
    if (k > 1) alive = alive & Continues(at, stride, k, bound);
    const V difference = V::Load(at + k * stride) - V::Load(at - k * stride);
    sum += Select(alive, difference * k, 0.);
    norm += Select(alive, V(2. * k * k), 0.);
  }
  slope.value = sum / norm;
  return slope;
}

}  // namespace surfit
