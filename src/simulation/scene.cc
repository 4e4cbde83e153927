#include "surfit/simulation/scene.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace surfit {

using Eigen::Vector3d;

namespace {

struct Sphere {
  Vector3d center;
  double radius;
};

Sphere BoundingSphere(const std::vector<ScenePoint>& points) {
  Eigen::AlignedBox3d box;
  for (const ScenePoint& point : points) box.extend(point.point_in_world);
  return {box.center(), box.diagonal().norm() / 2};
}

// The objects that can stand between the light and the points.
std::vector<int> Occluders(const Scene& scene, const PointLight& light, const Sphere& points) {
  const Vector3d to_points = points.center - light.position_in_world;
  const double distance = to_points.norm();
  const double half_angle =
      distance > points.radius ? std::asin(points.radius / distance) : static_cast<double>(M_PI);
  return scene.ObjectsInCone(light.position_in_world, to_points / distance, half_angle,
                             distance + points.radius);
}

bool InShadow(const Scene& scene, const ScenePoint& point, const Vector3d& to_light,
              const std::vector<int>& occluders) {
  constexpr double kOffSurface_m = 1e-4;
  const Vector3d start = point.point_in_world + kOffSurface_m * point.hit.normal_in_world;
  return scene.Intersect(start, to_light, occluders, 1.0).has_value();
}

float Daylight(const Vector3d& normal_in_world) {
  return 0.26f + 0.1f * static_cast<float>(normal_in_world.z());
}

// Light per unit reflectance; falls off slower than 1/r^2, as light in a room with pale walls does.
float LightFrom(const PointLight& light, const Vector3d& normal, const Vector3d& to_light) {
  constexpr double kReach_m = 2.5;
  const double distance = to_light.norm();
  const double cosine = normal.dot(to_light) / distance;
  const double relative = distance / kReach_m;
  return cosine <= 0 ? 0.f
                     : static_cast<float>(light.intensity * cosine / (1 + relative * relative));
}

}  // namespace

void Scene::Add(ShapePtr shape, const Rigid3d& world_from_object, Texture texture, float glow) {
  placements_.push_back({world_from_object.rotation.conjugate().toRotationMatrix(),
                         world_from_object.translation, shape->BoundingRadius()});
  objects_.push_back({std::move(shape), world_from_object, std::move(texture), glow});
}

std::optional<SceneHit> Scene::Intersect(const Vector3d& origin, const Vector3d& direction) const {
  std::vector<int> all(objects_.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<int>(i);
  return Intersect(origin, direction, all, std::numeric_limits<double>::infinity());
}

std::optional<SceneHit> Scene::Intersect(const Vector3d& origin, const Vector3d& direction,
                                         const std::vector<int>& candidates, double t_end) const {
  std::optional<ShapeHit> nearest;
  int object = -1;
  for (const int i : candidates) {
    const Placement& place = placements_[i];
    const auto hit =
        objects_[i].shape->Intersect(place.object_from_world * (origin - place.center_in_world),
                                     place.object_from_world * direction);
    if (hit && hit->t < t_end) {
      nearest = hit;
      object = i;
      t_end = hit->t;
    }
  }
  if (!nearest) return std::nullopt;
  const Vector3d normal = placements_[object].object_from_world.transpose() * nearest->normal;
  return SceneHit{nearest->t, normal, object, nearest->face};
}

std::vector<int> Scene::ObjectsInCone(const Vector3d& apex, const Vector3d& unit_axis,
                                      double half_angle_rad, double reach_m) const {
  // A ball of radius r at a distance d looms r / d = sin(b) wide; it reaches into the cone where
  // the angle to its centre is at most a + b, a the cone's half angle:
  //   cos(angle) >= cos(a + b) = cos(a) cos(b) - sin(a) sin(b), for a + b < pi.
  const double cos_a = std::cos(half_angle_rad), sin_a = std::sin(half_angle_rad);
  const bool is_narrow = half_angle_rad < M_PI / 2;
  std::vector<int> inside;
  for (std::size_t i = 0; i < placements_.size(); ++i) {
    const Vector3d to_center = placements_[i].center_in_world - apex;
    const double distance = to_center.norm(), radius = placements_[i].radius;
    if (distance - radius > reach_m) continue;
    if (is_narrow && distance > radius) {
      const double sin_b = radius / distance, cos_b = std::sqrt(1 - sin_b * sin_b);
      if (to_center.dot(unit_axis) < (cos_a * cos_b - sin_a * sin_b) * distance) continue;
    }
    inside.push_back(static_cast<int>(i));
  }
  return inside;
}

double Scene::Distance(const Vector3d& point_in_world) const {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    const Vector3d from_center = point_in_world - placements_[i].center_in_world;
    if (from_center.norm() - placements_[i].radius > nearest) continue;
    const double distance =
        objects_[i].shape->Distance(placements_[i].object_from_world * from_center);
    nearest = std::min(nearest, distance);
  }
  return nearest;
}

Eigen::Vector3f Scene::Reflectance(const SceneHit& hit, const Vector3d& point_in_world) const {
  const Placement& place = placements_[hit.object];
  return objects_[hit.object].texture(place.object_from_world *
                                      (point_in_world - place.center_in_world));
}

std::vector<Eigen::Vector3f> Scene::Light(const std::vector<ScenePoint>& points) const {
  if (points.empty()) return {};
  std::vector<float> light_sum;
  light_sum.reserve(points.size());
  for (const ScenePoint& point : points) {
    light_sum.push_back(Daylight(point.hit.normal_in_world) + objects_[point.hit.object].glow);
  }
  const Sphere sphere = BoundingSphere(points);
  for (const PointLight& light : lights) {
    const std::vector<int> occluders =
        light.casts_shadows ? Occluders(*this, light, sphere) : std::vector<int>();
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vector3d to_light = light.position_in_world - points[i].point_in_world;
      const float amount = LightFrom(light, points[i].hit.normal_in_world, to_light);
      if (amount > 0 && !InShadow(*this, points[i], to_light, occluders)) light_sum[i] += amount;
    }
  }
  std::vector<Eigen::Vector3f> reflected;
  reflected.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    reflected.emplace_back(light_sum[i] * Reflectance(points[i].hit, points[i].point_in_world));
  }
  return reflected;
}

}  // namespace surfit
