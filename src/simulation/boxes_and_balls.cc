// Shapes: half space, box, sphere, capsule and rounded box. The last three contain all points
// within a radius of a core. The core is a point, a segment or a box.
#include <algorithm>
#include <cmath>
#include <limits>

#include "surfit/simulation/scene.h"

namespace surfit {
namespace {

using Eigen::Vector3d;

class HalfSpace : public Shape {
 public:
  std::optional<ShapeHit> Intersect(const Vector3d& origin,
                                    const Vector3d& direction) const override {
    if (direction.z() >= 0 || origin.z() <= 0) return std::nullopt;
    return ShapeHit{-origin.z() / direction.z(), Vector3d::UnitZ(), 0};
  }
  double Distance(const Vector3d& point) const override { return point.z(); }
  double BoundingRadius() const override { return std::numeric_limits<double>::infinity(); }
};

class Box : public Shape {
 public:
  explicit Box(const Vector3d& size) : half_(size / 2) {}

  // Slab method: the ray is between two parallel faces in an interval of t. The ray hits the box if
  // the last entry is before the first exit.
  std::optional<ShapeHit> Intersect(const Vector3d& origin,
                                    const Vector3d& direction) const override {
    double enter = 0, exit = std::numeric_limits<double>::infinity();
    int enter_axis = -1;
    for (int axis = 0; axis < 3; ++axis) {
      if (direction[axis] == 0) {
        if (std::abs(origin[axis]) >= half_[axis]) return std::nullopt;
        continue;
      }
      const double inverse = 1 / direction[axis];
      const double middle = -origin[axis] * inverse;
      const double radius = half_[axis] * std::abs(inverse);
      if (middle - radius > enter) {
        enter = middle - radius;
        enter_axis = axis;
      }
      exit = std::min(exit, middle + radius);
    }
    if (enter_axis < 0 || enter >= exit) return std::nullopt;
    ShapeHit hit;
    hit.t = enter;
    const bool positive_face = direction[enter_axis] < 0;
    hit.normal[enter_axis] = positive_face ? 1 : -1;
    hit.face = 2 * enter_axis + (positive_face ? 1 : 0);
    return hit;
  }

  double Distance(const Vector3d& point) const override {
    const Vector3d beyond = point.cwiseAbs() - half_;
    return beyond.cwiseMax(0).norm() + std::min(0.0, beyond.maxCoeff());
  }
  double BoundingRadius() const override { return half_.norm(); }
  Vector3d HalfExtents() const override { return half_; }

 private:
  Vector3d half_;
};

class RoundShape : public Shape {
 public:
  // The core is the box |x_i| <= core_half_i, where half sizes may be 0.
  RoundShape(const Vector3d& core_half, double radius) : core_half_(core_half), radius_(radius) {}

  // Newton's method finds the zero of the surface distance along the ray. This distance is convex,
  // so no step passes the zero. If the distance grows, the ray misses the shape.
  std::optional<ShapeHit> Intersect(const Vector3d& origin,
                                    const Vector3d& direction) const override {
    constexpr double kOnSurface_m = 1e-10;
    constexpr int kMostSteps = 200;  // steps of tangent rays only halve the distance
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
  Vector3d HalfExtents() const override { return core_half_.array() + radius_; }

 private:
  Vector3d NearestInCore(const Vector3d& point) const {
    return point.cwiseMax(-core_half_).cwiseMin(core_half_);
  }

  Vector3d core_half_;
  double radius_;
};

}  // namespace

ShapePtr MakeHalfSpace() { return std::make_shared<HalfSpace>(); }
ShapePtr MakeBox(const Vector3d& size) { return std::make_shared<Box>(size); }

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
