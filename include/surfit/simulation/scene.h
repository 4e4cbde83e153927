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

// Intersection of a ray with a solid.
struct ShapeHit {
  double t = 0;                                      // at origin + t * direction, t > 0
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // outward, unit length
  int face = -1;                                     // number of the flat face, or Shape::kCurved
};

// Solid in its own frame, m. Const functions must be thread-safe. Rays intersect it from outside
// only: a ray that starts inside does not intersect.
class Shape {
 public:
  static constexpr int kCurved = -1;
  static constexpr int kMaxFaces = 6;  // flat faces are numbered 0 ... kMaxFaces - 1

  virtual ~Shape() = default;
  // Returns the first intersection, or std::nullopt. `direction` need not have unit length. Exact
  // up to rounding, or up to 1e-10 m for iterative solvers.
  virtual std::optional<ShapeHit> Intersect(const Eigen::Vector3d& origin,
                                            const Eigen::Vector3d& direction) const = 0;
  // Signed distance to the surface, m; negative inside.
  virtual double Distance(const Eigen::Vector3d& point) const = 0;
  // Radius of a bounding sphere around the origin of the solid, m; infinite if unbounded.
  virtual double BoundingRadius() const = 0;
  // Half size of a bounding box around the origin of the solid, m.
  virtual Eigen::Vector3d HalfExtents() const {
    return Eigen::Vector3d::Constant(BoundingRadius());
  }
};

using ShapePtr = std::shared_ptr<const Shape>;

// Solids with their centre at the origin, m. Sizes are not checked.
ShapePtr MakeHalfSpace();  // z <= 0; face 0 is the plane z = 0
ShapePtr MakeBox(const Eigen::Vector3d& size);
ShapePtr MakeSphere(double radius);
ShapePtr MakeRoundedBox(const Eigen::Vector3d& size, double edge_radius);  // 2 edge_radius <= size
// Capsule along z. `length`: distance of the centres of its caps.
ShapePtr MakeCapsule(double radius, double length);
// Truncated cone along z; cylinder if both radii are equal. Face 0: bottom, face 1: top.
ShapePtr MakeFrustum(double bottom_radius, double top_radius, double height);
ShapePtr MakeTorus(double ring_radius, double tube_radius);  // around z

// Linear reflectance in [0, 1] at a surface point in the object frame.
using Texture = std::function<Eigen::Vector3f(const Eigen::Vector3d& point_in_object)>;

// Solid with pose and appearance.
struct SceneObject {
  ShapePtr shape;
  Rigid3d world_from_object;
  Texture texture;
  float glow = 0;  // emitted light, in multiples of the reflectance
};

// Light source with Lambert shading. Decreases with 1 / (1 + (distance / 2.5 m)^2).
struct PointLight {
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();
  float intensity = 1;
  bool casts_shadows = true;
  Eigen::AlignedBox3d lit = {};  // lit region, e.g. a closed room; empty: everywhere
};

// First intersection of a ray with the scene.
struct SceneHit {
  double t = 0;  // at origin + t * direction
  Eigen::Vector3d normal_in_world = Eigen::Vector3d::Zero();
  int object = -1;
  int face = Shape::kCurved;
};

// Surface point to be shaded.
struct ScenePoint {
  SceneHit hit;
  Eigen::Vector3d point_in_world;
};

// Object that a ray may intersect, see Scene::ObjectsInCone().
struct RayCandidate {
  int object = 0;
  double distance_m = 0;  // lower bound of the distance from the ray origin
};

// Region that is closed except for doorways. Cameras in it look at its targets.
struct SceneCell {
  Eigen::AlignedBox3d space;  // space between the walls
  std::vector<int> targets;   // indices of Scene::targets
};

// Coloured solids in m, z up, with lights and camera targets. Const functions are thread-safe if
// the textures are.
class Scene {
 public:
  void Add(ShapePtr shape, const Rigid3d& world_from_object, Texture texture, float glow = 0);
  const std::vector<SceneObject>& objects() const { return objects_; }

  // Returns the first intersection, or std::nullopt. `direction` need not have unit length.
  std::optional<SceneHit> Intersect(const Eigen::Vector3d& origin,
                                    const Eigen::Vector3d& direction) const;
  // Like above, for the objects of `candidates`, sorted by distance as by ObjectsInCone().
  std::optional<SceneHit> Intersect(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                                    const std::vector<RayCandidate>& candidates) const;
  // True if an object is between `origin` and `origin` + `direction` (t < 1).
  bool IsBlocked(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                 const std::vector<RayCandidate>& candidates) const;

  // Objects that may intersect a cone of limited length, sorted by distance. The test is
  // conservative.
  std::vector<RayCandidate> ObjectsInCone(
      const Eigen::Vector3d& apex, const Eigen::Vector3d& unit_axis, double half_angle_rad,
      double reach_m = std::numeric_limits<double>::infinity()) const;

  // Distance to the nearest surface, m; exact outside solids, negative inside. Infinite for an
  // empty scene.
  double Distance(const Eigen::Vector3d& point_in_world) const;

  // Linear reflectance at an intersection.
  Eigen::Vector3f Reflectance(const SceneHit& hit, const Eigen::Vector3d& point_in_world) const;

  // Linear light of red, green and blue at neighbouring points: reflectance times incident light.
  // Lights are ambient daylight, brighter from above, and point lights with Lambert shading and
  // shadows.
  std::vector<Eigen::Vector3f> Light(const std::vector<ScenePoint>& points) const;

  std::vector<PointLight> lights;
  Eigen::AlignedBox3d camera_space;  // space of camera paths
  // Corners of the closed route of camera paths. Empty: free paths in `camera_space`.
  std::vector<Eigen::Vector3d> route;
  std::vector<Eigen::Vector3d> targets;  // points that camera paths look at
  std::vector<SceneCell> cells;          // empty: all targets are visible from everywhere

 private:
  struct Placement {
    Eigen::Matrix3d object_from_world;  // rotation
    Eigen::Vector3d center_in_world;
    double radius;
    Eigen::AlignedBox3d box_in_world;
  };
  // Bounds of consecutive objects, which are neighbours.
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

// Size of the scene "building".
struct BuildingOptions {
  int floors = 2;  // 1 to 100
  int rooms = 6;   // on all floors together; a multiple of `floors`

  void Visit(OptionVisitor& visitor);
};

// Names for MakeScene():
//   room          a furnished room of 4.6 to 6.5 m; size, furniture and colours vary with the seed
//   three_rooms   three rooms connected by doorways; a path leads through them and back in about
//                 1500 frames, and then again
//   building      furnished rooms on several floors (BuildingOptions), around a ring of corridors
//                 on each floor, with a staircase at each end. Rooms 2 k and 2 k + 1 are identical
//                 except for pictures, rugs and an object on the floor. A path leads through every
//                 room and closes its loops after whole floors
//   three_planes  floor and two walls that intersect at right angles in (0, 0, 0)
//   wall          the textured plane y = 2 m
//   sphere        a ball of radius 0.5 m at (0, 2, 1) above the floor z = 0
//   corridor      floor, ceiling (z = 2.4 m) and two walls (x = -1 and 1 m), unbounded along y
// All scenes have z up. In scenes without rooms, the seed changes only the textures.
std::vector<std::string> SceneNames();

// Creates a scene. Throws InputError for invalid options of a building, and for an unknown name
// with the list of names.
Scene MakeScene(const std::string& name, std::uint64_t seed = 1,
                const BuildingOptions& building = {});

}  // namespace surfit
