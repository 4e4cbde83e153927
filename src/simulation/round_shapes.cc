// Convex solids of all points within a radius of a core: a point (sphere), a segment (capsule) or a
// box (rounded box).
#include <algorithm>
#include <cmath>

#include "surfit/simulation/shape.h"

namespace surfit {
namespace {

using Eigen::Vector3d;

class RoundShape : public Shape {
 public:
  // The core is the box |x_i| <= core_half_i; some or all of the half sizes may be 0.
  RoundShape(const Vector3d& core_half, double radius) : core_half_(core_half), radius_(radius) {}

  // Newton's method on the distance along the ray. The distance from a convex body is a convex
  // function: its tangent lies below it, so that no step ever passes the root, and once the
  // distance grows, the ray has missed. Each step is at least the distance itself.
  std::optional<ShapeHit> Intersect(const Vector3d& origin,
                                    const Vector3d& direction) const override {
    constexpr double kOnSurface_m = 1e-10;
    constexpr int kMostSteps = 200;  // tangent rays only halve the distance: 2^-200 is below any
    const double speed = direction.norm();
    const double bound = BoundingRadius();
    const double middle = -origin.dot(direction) / (speed * speed);
    if ((origin + middle * direction).squaredNorm() > bound * bound) return std::nullopt;
    double t = 0;
    for (int step = 0; step < kMostSteps; ++step) {
      const Vector3d point = origin + t * direction;
      const Vector3d from_core = point - NearestInCore(point);
      const double core_distance = from_core.norm();
      const double distance = core_distance - radius_;
      if (t == 0 && distance <= 0) return std::nullopt;
      const Vector3d normal = from_core / core_distance;
      const double slope = normal.dot(direction);
      if (slope >= 0) return std::nullopt;
      if (distance < kOnSurface_m) return ShapeHit{t, normal, kCurved};
      t -= distance / slope;
    }
    return std::nullopt;
  }

  double Distance(const Vector3d& point) const override {
    const double core_distance = (point - NearestInCore(point)).norm();
    const double inside_core = std::min(0.0, (point.cwiseAbs() - core_half_).maxCoeff());
    return core_distance + inside_core - radius_;
  }
  double BoundingRadius() const override { return core_half_.norm() + radius_; }

 private:
  Vector3d NearestInCore(const Vector3d& point) const {
    return point.cwiseMax(-core_half_).cwiseMin(core_half_);
  }

  Vector3d core_half_;
  double radius_;
};

}  // namespace

ShapePtr MakeSphere(double radius) {
  return std::make_shared<RoundShape>(Vector3d::Zero(), radius);
}

ShapePtr MakeCapsule(double radius, double length) {
  return std::make_shared<RoundShape>(Vector3d(0, 0, length / 2), radius);
}

ShapePtr MakeRoundedBox(const Vector3d& size, double edge_radius) {
  return std::make_shared<RoundShape>(size / 2 - Vector3d::Constant(edge_radius), edge_radius);
}

}  // namespace surfit
