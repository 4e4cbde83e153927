#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>

namespace surfit {

// Where a ray enters a solid.
struct ShapeHit {
  double t = 0;                                      // at origin + t * direction, t > 0
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // outward, unit length
  int face = -1;                                     // the flat face that is hit, or Shape::kCurved
};

// A solid in its own frame, metres. Solids are seen from outside: a ray enters where it goes
// against the outward normal, and a ray that starts inside does not meet the solid.
class Shape {
 public:
  static constexpr int kCurved = -1;
  static constexpr int kMostFaces = 6;  // flat faces are numbered 0 ... kMostFaces - 1

  virtual ~Shape() = default;
  // The first entry of the ray; the direction need not have unit length. Exact to rounding where
  // a formula exists, else iterated to 1e-10 m.
  virtual std::optional<ShapeHit> Intersect(const Eigen::Vector3d& origin,
                                            const Eigen::Vector3d& direction) const = 0;
  // Exact distance to the surface, negative inside.
  virtual double Distance(const Eigen::Vector3d& point) const = 0;
  // The solid lies in a sphere of this radius about its origin; infinite if unbounded.
  virtual double BoundingRadius() const = 0;
};

using ShapePtr = std::shared_ptr<const Shape>;

// All are centred on the origin; lengths in metres.
ShapePtr MakeHalfSpace();  // z <= 0; its face is the plane z = 0
ShapePtr MakeBox(const Eigen::Vector3d& size);
ShapePtr MakeSphere(double radius);
ShapePtr MakeRoundedBox(const Eigen::Vector3d& size, double edge_radius);
ShapePtr MakeCapsule(double radius, double length);  // along z, length between the end centres
// A cut cone along z; a cylinder where both radii are the same. Faces: 0 bottom, 1 top.
ShapePtr MakeFrustum(double bottom_radius, double top_radius, double height);
ShapePtr MakeTorus(double ring_radius, double tube_radius);  // around z

}  // namespace surfit
