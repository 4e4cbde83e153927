#pragma once

#include <cmath>

#include "mapping/vector4.h"
#include "surfit/mapping/fusion.h"

namespace surfit {

// Positions and normals of four points or surfels.
struct FourPatches {
  Vector4 position, normal;

  FourPatches(const Vector4& positions, const Vector4& normals)
      : position(positions), normal(normals) {}
  template <typename T>
  FourPatches(const T& a, const T& b, const T& c, const T& d)
      : position(Transposed(a.position, b.position, c.position, d.position)),
        normal(Transposed(a.normal, b.normal, c.normal, d.normal)) {}
};

// Decides whether a point and a surfel are the same piece of surface, for four pairs at once.
class MergeGate {
 public:
  struct Verdict {
    Int4 same;         // mask
    Float4 distance2;  // between point and surfel, squared
  };

  explicit MergeGate(const FusionOptions& options)
      : max_distance_m_(options.max_distance_m),
        max_spacing_m_(options.max_spacing_m),
        min_cosine_(std::cos(options.max_normal_angle_rad)) {}

  // Points and surfels in the same frame. A point of radius 0 is none, and never the same.
  Verdict Judge(const FourPatches& point, Float4 point_radius_m, const FourPatches& surfel) const {
    const Vector4 gap = point.position - surfel.position;
    const Float4 along = Dot(surfel.normal, gap), distance2 = Dot(gap, gap);
    const Float4 across2 = distance2 - along * along;
    const Float4 reach = Min(point_radius_m, AllLanes(max_spacing_m_));
    const Int4 near = (along <= max_distance_m_) & (along >= -max_distance_m_);
    const Int4 parallel = Dot(surfel.normal, point.normal) >= min_cosine_;
    const Int4 is_point = point_radius_m > 0.f;
    return {is_point & near & (across2 <= reach * reach) & parallel, distance2};
  }

 private:
  const float max_distance_m_, max_spacing_m_, min_cosine_;
};

}  // namespace surfit
