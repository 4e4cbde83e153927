#include "surfit/simulation/render.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "surfit/core/image.h"
#include "surfit/core/parallel.h"
#include "surfit/simulation/scene.h"

namespace surfit {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

struct SurfacePoint {
  SceneHit hit;
  Vector3d point_in_world;
};

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

// The colours of points that lie near to each other: reflectance times light, the light being soft
// daylight from all around, brighter from above, and point lights with Lambert's law and shadows;
// a fixed exposure, sRGB.
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

// Small enough that few objects reach into a tile, large enough to be worth asking which.
int TileSize(const PinholeCamera& camera) { return std::clamp(camera.width / 8, 4, 16); }

struct View {
  const Scene& scene;
  const PinholeCamera& camera;
  Rigid3d world_from_camera;
  Eigen::Matrix3d rotation;  // world from camera

  Vector3d RayInWorld(double u, double v) const { return rotation * camera.Ray(u, v); }
};

struct Tile {
  int u_begin, u_end, v_begin, v_end;
};

std::vector<Tile> Tiles(const PinholeCamera& camera) {
  const int size = TileSize(camera);
  std::vector<Tile> tiles;
  for (int v = 0; v < camera.height; v += size) {
    for (int u = 0; u < camera.width; u += size) {
      tiles.push_back({u, std::min(u + size, camera.width), v, std::min(v + size, camera.height)});
    }
  }
  return tiles;
}

// The objects that rays of the tile can meet: those in the cone about the tile's middle ray that
// holds its four corner rays (and with them, it being convex, all between).
std::vector<int> ObjectsInTile(const View& view, const Tile& tile) {
  const int u_last = tile.u_end - 1, v_last = tile.v_end - 1;
  const Vector3d axis =
      view.RayInWorld((tile.u_begin + u_last) / 2.0, (tile.v_begin + v_last) / 2.0).normalized();
  double half_angle = 0;
  for (const auto& [u, v] : {std::pair{tile.u_begin, tile.v_begin}, std::pair{u_last, tile.v_begin},
                             std::pair{tile.u_begin, v_last}, std::pair{u_last, v_last}}) {
    const Vector3d corner = view.RayInWorld(u, v);
    half_angle = std::max(half_angle, std::atan2(axis.cross(corner).norm(), axis.dot(corner)));
  }
  constexpr double kRounding_rad = 1e-9;
  return view.scene.ObjectsInCone(view.world_from_camera.translation, axis,
                                  half_angle + kRounding_rad);
}

struct PixelHit {
  int u, v;
  SceneHit hit;
};

// The camera rays of the tile that meet something. The direction has z = 1 in the camera's frame,
// so that the ray parameter is the depth.
std::vector<PixelHit> TraceTile(const View& view, const Tile& tile) {
  const std::vector<int> candidates = ObjectsInTile(view, tile);
  std::vector<PixelHit> hits;
  for (int v = tile.v_begin; v < tile.v_end; ++v) {
    for (int u = tile.u_begin; u < tile.u_end; ++u) {
      const auto hit =
          view.scene.Intersect(view.world_from_camera.translation, view.RayInWorld(u, v),
                               candidates, std::numeric_limits<double>::infinity());
      if (hit) hits.push_back({u, v, *hit});
    }
  }
  return hits;
}

void RenderTile(const View& view, const Tile& tile, Rendering* rendering) {
  const std::vector<PixelHit> hits = TraceTile(view, tile);
  std::vector<SurfacePoint> points;
  points.reserve(hits.size());
  for (const auto& [u, v, hit] : hits) {
    const Vector3d point = view.world_from_camera.translation + hit.t * view.RayInWorld(u, v);
    points.push_back({hit, point});
    rendering->depth_m(u, v) = static_cast<float>(hit.t);
    const Vector3d normal = view.rotation.transpose() * hit.normal_in_world;
    rendering->normal.Set(u, v, normal.cast<float>());
    rendering->surface(u, v) = Rendering::SurfaceOf(hit);
  }
  if (rendering->color.empty()) return;
  const std::vector<Rgb8> colors = Shade(view.scene, points);
  for (std::size_t i = 0; i < hits.size(); ++i) rendering->color(hits[i].u, hits[i].v) = colors[i];
}

// Fills the colours if there is an image for them.
Rendering Render(const Scene& scene, const PinholeCamera& camera, const Rigid3d& world_from_camera,
                 Image<Rgb8> color) {
  camera.Validate("camera");
  Rendering rendering{Image<float>(camera.width, camera.height, 0.f), std::move(color),
                      VectorImage(camera.width, camera.height),
                      Image<std::int32_t>(camera.width, camera.height, Rendering::kNothing)};
  const View view{scene, camera, world_from_camera, world_from_camera.rotation.toRotationMatrix()};
  const std::vector<Tile> tiles = Tiles(camera);
  ParallelFor(0, static_cast<int>(tiles.size()), 8, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) RenderTile(view, tiles[i], &rendering);
  });
  return rendering;
}

}  // namespace

Rendering Render(const Scene& scene, const PinholeCamera& camera,
                 const Rigid3d& world_from_camera) {
  return Render(scene, camera, world_from_camera, Image<Rgb8>(camera.width, camera.height));
}

Rendering RenderGeometry(const Scene& scene, const PinholeCamera& camera,
                         const Rigid3d& world_from_camera) {
  return Render(scene, camera, world_from_camera, Image<Rgb8>());
}

RgbdFrame RenderFrame(const Scene& scene, const PinholeCamera& camera,
                      const Rigid3d& world_from_camera, int index, double stamp_s) {
  Rendering rendering = Render(scene, camera, world_from_camera);
  return {index, stamp_s, stamp_s, std::move(rendering.depth_m), std::move(rendering.color)};
}

}  // namespace surfit
