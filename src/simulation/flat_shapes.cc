// Solids of flat faces only: half space and box.
#include <algorithm>
#include <cmath>
#include <limits>

#include "surfit/simulation/shape.h"

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

  // The ray is inside each pair of parallel faces for an interval of t; it enters the box at the
  // last of the three entries, if that comes before the first exit.
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

 private:
  Vector3d half_;
};

}  // namespace

ShapePtr MakeHalfSpace() { return std::make_shared<HalfSpace>(); }
ShapePtr MakeBox(const Vector3d& size) { return std::make_shared<Box>(size); }

}  // namespace surfit
