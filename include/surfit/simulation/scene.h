#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "surfit/geometry/rigid3.h"
#include "surfit/simulation/shape.h"

namespace surfit {

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
};

// Where a ray meets the scene first.
struct SceneHit {
  double t = 0;  // at origin + t * direction
  Eigen::Vector3d normal_in_world = Eigen::Vector3d::Zero();
  int object = -1;
  int face = Shape::kCurved;
};

// Solids with colours, in metres, z up, and how they are lit and filmed.
class Scene {
 public:
  void Add(ShapePtr shape, const Rigid3d& world_from_object, Texture texture, float glow = 0);
  const std::vector<SceneObject>& objects() const { return objects_; }

  // The first object that the ray enters; the direction need not have unit length.
  std::optional<SceneHit> Intersect(const Eigen::Vector3d& origin,
                                    const Eigen::Vector3d& direction) const;
  // The same among some of the objects, and only for t < t_end.
  std::optional<SceneHit> Intersect(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                                    const std::vector<int>& candidates, double t_end) const;

  // The objects that may reach into a cone, cut off at a distance from its apex; some may not.
  std::vector<int> ObjectsInCone(const Eigen::Vector3d& apex, const Eigen::Vector3d& unit_axis,
                                 double half_angle_rad,
                                 double reach_m = std::numeric_limits<double>::infinity()) const;

  // Distance to the nearest surface in metres, exact outside all solids; negative inside one.
  double Distance(const Eigen::Vector3d& point_in_world) const;

  Eigen::Vector3f Reflectance(const SceneHit& hit, const Eigen::Vector3d& point_in_world) const;

  std::vector<PointLight> lights;
  Eigen::AlignedBox3d camera_space;    // where a camera path may lead ...
  std::vector<Eigen::Vector3d> route;  // ... and, unless empty, the corners of the loop it follows
  std::vector<Eigen::Vector3d> targets;  // what a camera path looks at

 private:
  struct Placement {
    Eigen::Matrix3d object_from_world;  // rotation
    Eigen::Vector3d center_in_world;
    double radius;
  };
  std::vector<SceneObject> objects_;
  std::vector<Placement> placements_;
};

}  // namespace surfit
