#include "simulation/shading.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace surfit {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

// IEC 61966-2-1, tabulated: linear light in [0, 1] to 8 bits.
std::uint8_t ToSrgb(float linear) {
  static const auto table = [] {
    std::array<std::uint8_t, 4096> bytes;
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      const double x = static_cast<double>(i) / (bytes.size() - 1);
      const double y = x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
      bytes[i] = static_cast<std::uint8_t>(std::lround(255 * y));
    }
    return bytes;
  }();
  return table[std::lround(std::clamp(linear, 0.f, 1.f) * (table.size() - 1))];
}

struct Sphere {
  Vector3d center;
  double radius;
};

Sphere BoundingSphere(const std::vector<SurfacePoint>& points) {
  Eigen::AlignedBox3d box;
  for (const SurfacePoint& point : points) box.extend(point.point_in_world);
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

bool InShadow(const Scene& scene, const SurfacePoint& point, const Vector3d& to_light,
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

std::vector<Rgb8> Shade(const Scene& scene, const std::vector<SurfacePoint>& points) {
  if (points.empty()) return {};
  std::vector<float> light_sum;
  for (const SurfacePoint& point : points) {
    light_sum.push_back(Daylight(point.hit.normal_in_world) +
                        scene.objects()[point.hit.object].glow);
  }
  const Sphere sphere = BoundingSphere(points);
  for (const PointLight& light : scene.lights) {
    const std::vector<int> occluders =
        light.casts_shadows ? Occluders(scene, light, sphere) : std::vector<int>();
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vector3d to_light = light.position_in_world - points[i].point_in_world;
      const float amount = LightFrom(light, points[i].hit.normal_in_world, to_light);
      if (amount > 0 && !InShadow(scene, points[i], to_light, occluders)) light_sum[i] += amount;
    }
  }
  std::vector<Rgb8> colors;
  colors.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector3f radiance =
        light_sum[i] * scene.Reflectance(points[i].hit, points[i].point_in_world);
    colors.push_back({ToSrgb(radiance.x()), ToSrgb(radiance.y()), ToSrgb(radiance.z())});
  }
  return colors;
}

}  // namespace surfit
