#include <algorithm>
#include <cmath>

#include "surfit/simulation/scene.h"

namespace surfit {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

double DistanceToSegment(const Vector2d& point, const Vector2d& a, const Vector2d& b) {
  const Vector2d along = b - a;
  const double share = std::clamp((point - a).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (point - a - share * along).norm();
}

// Solid x^2 + y^2 <= r(z)^2, |z| <= height / 2, with r(z) = r_middle + slope * z.
class Frustum : public Shape {
 public:
  Frustum(double bottom_radius, double top_radius, double height)
      : half_height_(height / 2),
        middle_radius_((bottom_radius + top_radius) / 2),
        slope_((top_radius - bottom_radius) / height) {}

  std::optional<ShapeHit> Intersect(const Vector3d& origin,
                                    const Vector3d& direction) const override {
    // A ray enters a convex body once: at a cap or at the side.
    if (auto hit = IntersectCap(origin, direction)) return hit;
    return IntersectSide(origin, direction);
  }

  double Distance(const Vector3d& point) const override {
    const Vector2d p(point.head<2>().norm(), point.z());  // in the half plane (radius, z)
    const Vector2d bottom(RadiusAt(-half_height_), -half_height_);
    const Vector2d top(RadiusAt(half_height_), half_height_);
    const double distance =
        std::min({DistanceToSegment(p, bottom, top), DistanceToSegment(p, {0, bottom.y()}, bottom),
                  DistanceToSegment(p, {0, top.y()}, top)});
    const bool inside = std::abs(p.y()) < half_height_ && p.x() < RadiusAt(p.y());
    return inside ? -distance : distance;
  }

  double BoundingRadius() const override { return std::hypot(half_height_, LargestRadius()); }
  Vector3d HalfExtents() const override { return {LargestRadius(), LargestRadius(), half_height_}; }

 private:
  double RadiusAt(double z) const { return middle_radius_ + slope_ * z; }
  double LargestRadius() const { return std::max(RadiusAt(-half_height_), RadiusAt(half_height_)); }

  std::optional<ShapeHit> IntersectCap(const Vector3d& origin, const Vector3d& direction) const {
    if (direction.z() == 0) return std::nullopt;
    const double side = direction.z() < 0 ? 1 : -1;
    const double t = (side * half_height_ - origin.z()) / direction.z();
    const Vector3d point = origin + t * direction;
    if (t <= 0 || point.head<2>().norm() > RadiusAt(side * half_height_)) return std::nullopt;
    return ShapeHit{t, {0, 0, side}, side > 0 ? 1 : 0};
  }

  // Intersects the ray with the side. Along the ray, x^2 + y^2 - r(z)^2 = a t^2 + 2 b t + c = 0.
  std::optional<ShapeHit> IntersectSide(const Vector3d& origin, const Vector3d& direction) const {
    const double radius = RadiusAt(origin.z()), growth = slope_ * direction.z();
    const double a = direction.head<2>().squaredNorm() - growth * growth;
    const double b = origin.head<2>().dot(direction.head<2>()) - radius * growth;
    const double c = origin.head<2>().squaredNorm() - radius * radius;
    const double discriminant = b * b - a * c;
    if (discriminant <= 0) return std::nullopt;
    // Both roots without cancellation. If a is 0, the first root is infinite.
    const double q = -(b + std::copysign(std::sqrt(discriminant), b));
    for (const double t : {q / a, c / q}) {
      if (!(t > 0) || !std::isfinite(t)) continue;
      const Vector3d point = origin + t * direction;
      const double r = RadiusAt(point.z());
      if (std::abs(point.z()) > half_height_ || r <= 0) continue;
      const Vector3d normal = Vector3d(point.x(), point.y(), -slope_ * r).normalized();
      if (normal.dot(direction) < 0) return ShapeHit{t, normal, kCurved};
    }
    return std::nullopt;
  }

  double half_height_, middle_radius_, slope_;
};

class Torus : public Shape {
 public:
  Torus(double ring_radius, double tube_radius) : ring_radius_(ring_radius), tube_(tube_radius) {}

  // Sphere tracing (Hart 1996): a step of the signed distance never passes the surface.
  std::optional<ShapeHit> Intersect(const Vector3d& origin,
                                    const Vector3d& direction) const override {
    constexpr double kOnSurface_m = 1e-10;
    constexpr int kMostSteps = 2000;  // typically below 100; limit for rays that miss
    const double speed = direction.norm(), bound = BoundingRadius();
    const double middle = -origin.dot(direction) / (speed * speed);
    const double chord2 = bound * bound - (origin + middle * direction).squaredNorm();
    if (chord2 <= 0) return std::nullopt;
    double t = std::max(0.0, middle - std::sqrt(chord2) / speed);
    const double t_end = middle + std::sqrt(chord2) / speed;
    if (Distance(origin) <= 0) return std::nullopt;
    for (int step = 0; step < kMostSteps && t < t_end; ++step) {
      const Vector3d point = origin + t * direction;
      const double distance = Distance(point);
      if (distance < kOnSurface_m) {
        return ShapeHit{t, (point - NearestOnRing(point)).normalized(), kCurved};
      }
      t += distance / speed;
    }
    return std::nullopt;
  }

  double Distance(const Vector3d& point) const override {
    return std::hypot(point.head<2>().norm() - ring_radius_, point.z()) - tube_;
  }
  double BoundingRadius() const override { return ring_radius_ + tube_; }
  Vector3d HalfExtents() const override { return {BoundingRadius(), BoundingRadius(), tube_}; }

 private:
  Vector3d NearestOnRing(const Vector3d& point) const {
    const double scale = ring_radius_ / point.head<2>().norm();
    return {scale * point.x(), scale * point.y(), 0};
  }

  double ring_radius_, tube_;
};

}  // namespace

ShapePtr MakeFrustum(double bottom_radius, double top_radius, double height) {
  return std::make_shared<Frustum>(bottom_radius, top_radius, height);
}

ShapePtr MakeTorus(double ring_radius, double tube_radius) {
  return std::make_shared<Torus>(ring_radius, tube_radius);
}

}  // namespace surfit
