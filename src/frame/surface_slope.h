#pragma once

#include <cmath>
#include <cstddef>

#include "surfit/frame/preprocess.h"
#include "surfit/geometry/sensor.h"

namespace surfit {

// By how much inverse depth r (1/m) may change from pixel to pixel without being a depth edge:
// noise, and a surface slanted by max_slant_rad, whose r changes by r tan(slant) / f.
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

// Whether both neighbours at offset k continue the surface from offset k - 1, for the lanes at a
// pixel of an InverseDepthBand; offset k lies k * stride away.
template <typename V>
typename V::Mask Continues(const float* at, std::ptrdiff_t stride, int k, const V& bound) {
  const V ahead = V::Load(at + k * stride) - V::Load(at + (k - 1) * stride);
  const V behind = V::Load(at - k * stride) - V::Load(at - (k - 1) * stride);
  return Max(abs(ahead), abs(behind)) < bound;
}

template <typename V>
struct SurfaceSlope {
  V value;
  typename V::Mask valid;  // else not even the nearest offset continues the surface
};

// Least-squares slope of inverse depth along one direction: sum over offsets k of
// k (r(+k) - r(-k)) / sum 2 k^2, as far as both sides continue the surface from offset to offset.
template <typename V>
SurfaceSlope<V> SlopeAlong(const float* at, std::ptrdiff_t stride, int radius, const V& bound) {
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
