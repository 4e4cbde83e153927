#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>

#include "surfit/core/lanes.h"
#include "surfit/mapping/fusion.h"

namespace surfit {

// Position (m) and unit normal of a surface patch. All patches of a call are in one frame.
template <typename Number>
struct PatchOf {
  Number x, y, z;
  Number nx, ny, nz;
};
using Patch = PatchOf<float>;

// Tests if a point and a surfel belong to the same surface. Number is float or Lanes.
//
// Depth noise moves a point p along its ray. On a slanted surface, this motion has a tangential
// component. Therefore, distances use the intersection of the ray with the surfel plane (centre s,
// normal n):
//   h = n . (p - s) along the normal,  a = p - s - h / (n . p) p across the surface.
class MergeGate {
 public:
  // Result without a match.
  static constexpr float kNever = std::numeric_limits<float>::infinity();

  // Copies the thresholds.
  explicit MergeGate(const FusionOptions& options)
      : max_distance_m_(options.merge_distance_m),
        max_spacing_m_(options.max_spacing_m),
        min_cosine_(std::cos(options.merge_angle_rad)),
        duplicate_ratio_(options.duplicate_ratio) {}

  // h^2 + a^2 of a measured point and a surfel in the camera frame; kNever without a match. Radius
  // 0 and missing normals never match. Matches have |h| <= merge_distance_m, |a| <= min(radius,
  // max_spacing_m) and an angle of normals of at most merge_angle_rad.
  template <typename Number>
  Number SquaredDistanceOnRay(const PatchOf<Number>& point, const Number& point_radius_m,
                              const PatchOf<Number>& surfel) const {
    return SquaredDistanceOnRayWithin(SquaredReach(point_radius_m), point, surfel);
  }

  // Squared upper limit of |a| for a point of this radius.
  template <typename Number>
  Number SquaredReach(const Number& point_radius_m) const {
    const Number reach = Least(point_radius_m, Number(max_spacing_m_));
    return reach * reach;
  }

  // As SquaredDistanceOnRay(), with the SquaredReach() of the point instead of its radius.
  template <typename Number>
  Number SquaredDistanceOnRayWithin(const Number& reach2, const PatchOf<Number>& point,
                                    const PatchOf<Number>& surfel) const {
    const Number dx = point.x - surfel.x, dy = point.y - surfel.y, dz = point.z - surfel.z;
    const Number along = surfel.nx * dx + surfel.ny * dy + surfel.nz * dz;
    const Number share = along / (surfel.nx * point.x + surfel.ny * point.y + surfel.nz * point.z);
    const Number ax = dx - share * point.x, ay = dy - share * point.y, az = dz - share * point.z;
    return IfMatching(reach2, along * along, ax * ax + ay * ay + az * az, point, surfel);
  }

  // Half size of the box around a surfel with this normal that has all matches of
  // SquaredDistance().
  Eigen::Vector3f Reach(const Eigen::Vector3f& normal) const {
    const Eigen::Array3f across = (1 - normal.array().square()).max(0).sqrt();
    return max_distance_m_ * normal.array().abs() + max_spacing_m_ * across;
  }

  // As SquaredDistanceOnRay(), but in any frame: a is the offset p - s - h n across the surface.
  template <typename Number>
  Number SquaredDistance(const PatchOf<Number>& point, const Number& point_radius_m,
                         const PatchOf<Number>& surfel) const {
    return SquaredDistanceWithin(SquaredReach(point_radius_m), point, surfel);
  }

  // Squared distance of two duplicate surfels along and across the normal of `b`; kNever for other
  // surfels. Duplicates pass the gate with a smaller limit of |a|: duplicate_ratio times the least
  // of both radii and max_spacing_m.
  template <typename Number>
  Number SquaredDistanceOfDuplicates(const PatchOf<Number>& a, const Number& radius_a_m,
                                     const PatchOf<Number>& b, const Number& radius_b_m) const {
    const Number least = Least(Least(radius_a_m, radius_b_m), Number(max_spacing_m_));
    const Number reach = Number(duplicate_ratio_) * least;
    return SquaredDistanceWithin(reach * reach, a, b);
  }

 private:
  template <typename Number>
  static Number Least(const Number& a, const Number& b) {
    return Select(a < b, a, b);
  }

  template <typename Number>
  Number SquaredDistanceWithin(const Number& reach2, const PatchOf<Number>& point,
                               const PatchOf<Number>& surfel) const {
    const Number dx = point.x - surfel.x, dy = point.y - surfel.y, dz = point.z - surfel.z;
    const Number along = surfel.nx * dx + surfel.ny * dy + surfel.nz * dz;
    const Number along2 = along * along;
    return IfMatching(reach2, along2, dx * dx + dy * dy + dz * dz - along2, point, surfel);
  }

  template <typename Number>
  Number IfMatching(const Number& reach2, const Number& along2, const Number& across2,
                    const PatchOf<Number>& point, const PatchOf<Number>& surfel) const {
    const Number cosine = surfel.nx * point.nx + surfel.ny * point.ny + surfel.nz * point.nz;
    const auto near = along2 <= Number(max_distance_m_ * max_distance_m_);
    const auto above = (reach2 > Number(0.f)) & (across2 <= reach2);
    return Select(near & above & (cosine >= Number(min_cosine_)), along2 + across2, Number(kNever));
  }

  const float max_distance_m_, max_spacing_m_, min_cosine_, duplicate_ratio_;
};

}  // namespace surfit
