#include "surfit/simulation/scene.h"

#include <algorithm>
#include <cmath>
#include <tuple>
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

// Start of a shadow ray. The offset from the surface prevents a self-intersection.
Vector3d OffSurface(const ScenePoint& point) {
  constexpr double kOffSurface_m = 1e-4;
  return point.point_in_world + kOffSurface_m * point.hit.normal_in_world;
}

bool Lights(const PointLight& light, const Vector3d& point) {
  return light.lit.isEmpty() || light.lit.contains(point);
}

bool LightsAny(const PointLight& light, const Sphere& points) {
  return light.lit.isEmpty() || light.lit.exteriorDistance(points.center) <= points.radius;
}

float Daylight(const Vector3d& normal_in_world) {
  return 0.26f + 0.1f * static_cast<float>(normal_in_world.z());
}

// Light that a surface of reflectance 1 reflects. It decreases more slowly than 1 / distance^2,
// because the bright walls of a room reflect light.
float LightFrom(const PointLight& light, const Vector3d& normal, const Vector3d& to_light) {
  constexpr double kReach_m = 2.5;
  const double distance = to_light.norm();
  const double cosine = normal.dot(to_light) / distance;
  const double relative = distance / kReach_m;
  return cosine <= 0 ? 0.f
                     : static_cast<float>(light.intensity * cosine / (1 + relative * relative));
}

}  // namespace

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Eigen::AlignedBox3d BoxInWorld(const Shape& shape, const Rigid3d& world_from_object) {
  const Vector3d half = shape.HalfExtents();
  if (!half.allFinite()) {
    return {Vector3d::Constant(-kInfinity), Vector3d::Constant(kInfinity)};
  }
  const Vector3d reach = world_from_object.rotation.toRotationMatrix().cwiseAbs() * half;
  return {world_from_object.translation - reach, world_from_object.translation + reach};
}

struct Cone {
  Cone(Vector3d cone_apex, Vector3d unit_axis, double half_angle_rad, double cone_reach_m)
      : apex(std::move(cone_apex)),
        axis(std::move(unit_axis)),
        cos_a(std::cos(half_angle_rad)),
        sin_a(std::sin(half_angle_rad)),
        reach_m(cone_reach_m),
        is_narrow(half_angle_rad < M_PI / 2) {}

  // A sphere of radius r at distance d has the angular radius b with sin(b) = r / d. It intersects
  // a cone of half angle a if the angle to its centre is at most a + b:
  //   cos(angle) >= cos(a + b) = cos(a) cos(b) - sin(a) sin(b), for a + b < pi.
  bool Meets(const Vector3d& center, double radius) const {
    if (!(radius < kInfinity)) return true;
    const Vector3d to_center = center - apex;
    const double distance = to_center.norm();
    if (distance - radius > reach_m) return false;
    if (!is_narrow || distance <= radius) return true;
    const double sin_b = radius / distance, cos_b = std::sqrt(1 - sin_b * sin_b);
    return to_center.dot(axis) >= (cos_a * cos_b - sin_a * sin_b) * distance;
  }

  Vector3d apex, axis;
  double cos_a, sin_a, reach_m;
  bool is_narrow;
};

}  // namespace

void Scene::Add(ShapePtr shape, const Rigid3d& world_from_object, Texture texture, float glow) {
  const Eigen::AlignedBox3d box = BoxInWorld(*shape, world_from_object);
  placements_.push_back({world_from_object.rotation.conjugate().toRotationMatrix(),
                         world_from_object.translation, shape->BoundingRadius(), box});
  if (objects_.size() % kGroupSize == 0) groups_.emplace_back();
  Group& group = groups_.back();
  group.box_in_world.extend(box);
  group.center_in_world = group.box_in_world.center();
  group.radius = group.box_in_world.diagonal().norm() / 2;
  objects_.push_back({std::move(shape), world_from_object, std::move(texture), glow});
}

std::optional<SceneHit> Scene::Intersect(const Vector3d& origin, const Vector3d& direction) const {
  std::vector<RayCandidate> all(objects_.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i].object = static_cast<int>(i);
  return Intersect(origin, direction, all);
}

// If two objects have equal t, the ray hits the object that was added first.
std::optional<SceneHit> Scene::Intersect(const Vector3d& origin, const Vector3d& direction,
                                         const std::vector<RayCandidate>& candidates) const {
  constexpr double kRounding = 1 + 1e-9;
  const double speed = kRounding * direction.norm();
  std::optional<ShapeHit> nearest;
  int object = -1;
  double t_end = kInfinity;
  for (const auto& [i, distance_m] : candidates) {
    if (distance_m > t_end * speed) break;
    const Placement& place = placements_[i];
    const auto hit =
        objects_[i].shape->Intersect(place.object_from_world * (origin - place.center_in_world),
                                     place.object_from_world * direction);
    if (hit && (hit->t < t_end || (hit->t == t_end && i < object))) {
      nearest = hit;
      object = i;
      t_end = hit->t;
    }
  }
  if (!nearest) return std::nullopt;
  const Vector3d normal = placements_[object].object_from_world.transpose() * nearest->normal;
  return SceneHit{nearest->t, normal, object, nearest->face};
}

bool Scene::IsBlocked(const Vector3d& origin, const Vector3d& direction,
                      const std::vector<RayCandidate>& candidates) const {
  return std::any_of(candidates.begin(), candidates.end(), [&](const RayCandidate& candidate) {
    const Placement& place = placements_[candidate.object];
    const auto hit = objects_[candidate.object].shape->Intersect(
        place.object_from_world * (origin - place.center_in_world),
        place.object_from_world * direction);
    return hit && hit->t < 1;
  });
}

std::vector<RayCandidate> Scene::ObjectsInCone(const Vector3d& apex, const Vector3d& unit_axis,
                                               double half_angle_rad, double reach_m) const {
  const Cone cone(apex, unit_axis, half_angle_rad, reach_m);
  std::vector<RayCandidate> inside;
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    if (!cone.Meets(groups_[g].center_in_world, groups_[g].radius)) continue;
    const std::size_t end = std::min(objects_.size(), (g + 1) * kGroupSize);
    for (std::size_t i = g * kGroupSize; i < end; ++i) {
      const Placement& place = placements_[i];
      if (!cone.Meets(place.center_in_world, place.radius)) continue;
      inside.push_back({static_cast<int>(i), place.box_in_world.exteriorDistance(apex)});
    }
  }
  std::sort(inside.begin(), inside.end(), [](const RayCandidate& a, const RayCandidate& b) {
    return std::tie(a.distance_m, a.object) < std::tie(b.distance_m, b.object);
  });
  return inside;
}

// Objects that can occlude the light. They intersect the cone from the light to the points, and the
// bounding box of light and points.
std::vector<RayCandidate> Scene::Occluders(const PointLight& light,
                                           const std::vector<ScenePoint>& points) const {
  const Sphere sphere = BoundingSphere(points);
  const Vector3d to_points = sphere.center - light.position_in_world;
  const double distance = to_points.norm();
  const double half_angle =
      distance > sphere.radius ? std::asin(sphere.radius / distance) : static_cast<double>(M_PI);
  Eigen::AlignedBox3d between(light.position_in_world);
  for (const ScenePoint& point : points) between.extend(OffSurface(point));
  std::vector<RayCandidate> occluders = ObjectsInCone(light.position_in_world, to_points / distance,
                                                      half_angle, distance + sphere.radius);
  occluders.erase(
      std::remove_if(occluders.begin(), occluders.end(),
                     [&](const RayCandidate& candidate) {
                       return !placements_[candidate.object].box_in_world.intersects(between);
                     }),
      occluders.end());
  return occluders;
}

double Scene::Distance(const Vector3d& point_in_world) const {
  double nearest = kInfinity;
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    if (groups_[g].box_in_world.exteriorDistance(point_in_world) > nearest) continue;
    const std::size_t end = std::min(objects_.size(), (g + 1) * kGroupSize);
    for (std::size_t i = g * kGroupSize; i < end; ++i) {
      const Vector3d from_center = point_in_world - placements_[i].center_in_world;
      if (from_center.norm() - placements_[i].radius > nearest) continue;
      const double distance =
          objects_[i].shape->Distance(placements_[i].object_from_world * from_center);
      nearest = std::min(nearest, distance);
    }
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
    if (!LightsAny(light, sphere)) continue;
    const std::vector<RayCandidate> occluders =
        light.casts_shadows ? Occluders(light, points) : std::vector<RayCandidate>();
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (!Lights(light, points[i].point_in_world)) continue;
      const Vector3d to_light = light.position_in_world - points[i].point_in_world;
      const float amount = LightFrom(light, points[i].hit.normal_in_world, to_light);
      if (amount > 0 && !IsBlocked(OffSurface(points[i]), to_light, occluders)) {
        light_sum[i] += amount;
      }
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
