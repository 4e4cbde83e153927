#pragma once

#include <cmath>
#include <limits>

#include "surfit/mapping/fusion.h"

namespace surfit {

// Position and normal of a point or surfel.
struct Patch {
  float x, y, z;
  float nx, ny, nz;
};

// Decides whether a point and a surfel are the same piece of surface. Free of branches, so that
// loops over pairs can do several at once.
class MergeGate {
 public:
  static constexpr float kNever = std::numeric_limits<float>::infinity();

  explicit MergeGate(const FusionOptions& options)
      : max_distance_m_(options.max_distance_m),
        max_spacing_m_(options.max_spacing_m),
        min_cosine_(std::cos(options.max_normal_angle_rad)) {}

  // The squared distance between a point and a surfel, both in the same frame, if they are the
  // same; else kNever. A point of radius 0 is none.
  float SquaredDistance(const Patch& point, float point_radius_m, const Patch& surfel) const {
    const float dx = point.x - surfel.x, dy = point.y - surfel.y, dz = point.z - surfel.z;
    const float along = surfel.nx * dx + surfel.ny * dy + surfel.nz * dz;
    const float distance2 = dx * dx + dy * dy + dz * dz;
    const float across2 = distance2 - along * along;
    const float reach = point_radius_m < max_spacing_m_ ? point_radius_m : max_spacing_m_;
    const float cosine = surfel.nx * point.nx + surfel.ny * point.ny + surfel.nz * point.nz;
    const bool near = (along <= max_distance_m_) & (along >= -max_distance_m_);
    const bool above = (point_radius_m > 0.f) & (across2 <= reach * reach);
    return near & above & (cosine >= min_cosine_) ? distance2 : kNever;
  }

 private:
  const float max_distance_m_, max_spacing_m_, min_cosine_;
};

}  // namespace surfit
