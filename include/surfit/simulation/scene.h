#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "surfit/geometry/rigid3.h"

namespace surfit {

class OptionVisitor;

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
  // And in the box |x_i| <= this.
  virtual Eigen::Vector3d HalfExtents() const {
    return Eigen::Vector3d::Constant(BoundingRadius());
  }
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

// Linear reflectance in [0, 1] of a surface at a point of the object's own frame.
using Texture = std::function<Eigen::Vector3f(const Eigen::Vector3d& point_in_object)>;

// A shape at its place, with its looks.
struct SceneObject {
  ShapePtr shape;
  Rigid3d world_from_object;
  Texture texture;
  float glow = 0;  // light that the surface gives by itself, as a multiple of its reflectance
};

// A lamp.
struct PointLight {
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();
  float intensity = 1;
  bool casts_shadows = true;
  Eigen::AlignedBox3d lit = {};  // where its light gets to, a closed room; everywhere if empty
};

// Where a ray meets the scene first.
struct SceneHit {
  double t = 0;  // at origin + t * direction
  Eigen::Vector3d normal_in_world = Eigen::Vector3d::Zero();
  int object = -1;
  int face = Shape::kCurved;
};

// The point of the scene where a ray meets it.
struct ScenePoint {
  SceneHit hit;
  Eigen::Vector3d point_in_world;
};

// An object that a ray may meet.
struct RayCandidate {
  int object = 0;
  double distance_m = 0;  // from where the ray starts, at least
};

// A part of a scene that is closed but for doorways: who is in it looks at what is in it.
struct SceneCell {
  Eigen::AlignedBox3d space;  // between its walls
  std::vector<int> targets;   // of Scene::targets
};

// Solids with colours, in metres, z up, and how they are lit and filmed.
class Scene {
 public:
  void Add(ShapePtr shape, const Rigid3d& world_from_object, Texture texture, float glow = 0);
  const std::vector<SceneObject>& objects() const { return objects_; }

  // The first object that the ray enters; the direction need not have unit length.
  std::optional<SceneHit> Intersect(const Eigen::Vector3d& origin,
                                    const Eigen::Vector3d& direction) const;
  // The same among some of the objects, nearest first.
  std::optional<SceneHit> Intersect(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                                    const std::vector<RayCandidate>& candidates) const;
  // Whether the ray enters one of them for t < 1.
  bool IsBlocked(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                 const std::vector<RayCandidate>& candidates) const;

  // The objects that may reach into a cone, cut off at a distance from its apex, nearest first;
  // some may not.
  std::vector<RayCandidate> ObjectsInCone(
      const Eigen::Vector3d& apex, const Eigen::Vector3d& unit_axis, double half_angle_rad,
      double reach_m = std::numeric_limits<double>::infinity()) const;

  // Distance to the nearest surface in metres, exact outside all solids; negative inside one.
  double Distance(const Eigen::Vector3d& point_in_world) const;

  Eigen::Vector3f Reflectance(const SceneHit& hit, const Eigen::Vector3d& point_in_world) const;

  // Linear light, red green blue, from points that lie near to each other: reflectance times the
  // light that falls there, which is soft daylight from all around, brighter from above, and point
  // lights with Lambert's law and shadows.
  std::vector<Eigen::Vector3f> Light(const std::vector<ScenePoint>& points) const;

  std::vector<PointLight> lights;
  Eigen::AlignedBox3d camera_space;    // where a camera path may lead ...
  std::vector<Eigen::Vector3d> route;  // ... and, unless empty, the corners of the loop it follows
  std::vector<Eigen::Vector3d> targets;  // what a camera path looks at
  std::vector<SceneCell> cells;          // none: all targets may be looked at from anywhere

 private:
  struct Placement {
    Eigen::Matrix3d object_from_world;  // rotation
    Eigen::Vector3d center_in_world;
    double radius;
    Eigen::AlignedBox3d box_in_world;
  };
  // Objects that were added one after the other, so that they lie near to each other.
  struct Group {
    Eigen::AlignedBox3d box_in_world;
    Eigen::Vector3d center_in_world;
    double radius;
  };
  static constexpr std::size_t kGroupSize = 16;

  std::vector<RayCandidate> Occluders(const PointLight& light,
                                      const std::vector<ScenePoint>& points) const;

  std::vector<SceneObject> objects_;
  std::vector<Placement> placements_;
  std::vector<Group> groups_;
};

// How large the scene "building" is.
struct BuildingOptions {
  int floors = 2;
  int rooms = 6;

  void Visit(OptionVisitor& visitor);
};

// The names MakeScene() knows:
//   room          a furnished room of 4 to 8 m; its size, furniture and colours vary with the seed
//   three_rooms   three such rooms joined by doorways; a path walks through them and back in about
//                 1500 frames, and then again
//   building      furnished rooms on some floors (BuildingOptions), around a ring of corridors on
//                 each, with a staircase at each end. Rooms 2 k and 2 k + 1 are alike but for
//                 pictures, rugs and a thing on the floor. A path walks through every room and
//                 closes its loops after whole floors
//   three_planes  floor and two walls that meet at right angles in (0, 0, 0)
//   wall          the plane y = 2 m, textured
//   sphere        a ball of radius 0.5 m at (0, 2, 1) above the floor z = 0
//   corridor      floor, ceiling (z = 2.4 m) and two walls (x = -1 and 1 m), endless along y
// All have z up; all but the rooms are the same for every seed, apart from their textures.
std::vector<std::string> SceneNames();

// Throws InputError that lists the names, for a name that is none of them, and for options that are
// not valid.
Scene MakeScene(const std::string& name, std::uint64_t seed = 1,
                const BuildingOptions& building = {});

}  // namespace surfit
