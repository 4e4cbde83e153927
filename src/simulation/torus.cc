#include <algorithm>
#include <cmath>

#include "surfit/simulation/shape.h"

namespace surfit {
namespace {

using Eigen::Vector3d;

class Torus : public Shape {
 public:
  Torus(double ring_radius, double tube_radius) : ring_radius_(ring_radius), tube_(tube_radius) {}

  // Sphere tracing (Hart 1996): a step as long as the distance never passes the surface.
  std::optional<ShapeHit> Intersect(const Vector3d& origin,
                                    const Vector3d& direction) const override {
    constexpr double kOnSurface_m = 1e-10;
    constexpr int kMostSteps = 2000;  // hardly ever more than 100; then the ray counts as a miss
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

 private:
  Vector3d NearestOnRing(const Vector3d& point) const {
    const double scale = ring_radius_ / point.head<2>().norm();
    return {scale * point.x(), scale * point.y(), 0};
  }

  double ring_radius_, tube_;
};

}  // namespace

ShapePtr MakeTorus(double ring_radius, double tube_radius) {
  return std::make_shared<Torus>(ring_radius, tube_radius);
}

}  // namespace surfit
