#include "surfit/simulation/render.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "surfit/core/parallel.h"

namespace surfit {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

// Table from linear light in [0, 1] to 8-bit sRGB (IEC 61966-2-1).
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

Rgb8 ToSrgb(const Vector3f& light) {
  return {ToSrgb(light.x()), ToSrgb(light.y()), ToSrgb(light.z())};
}

// trade-off: small tiles have few candidate objects, large tiles need fewer searches
int TileSize(const PinholeCamera& camera) { return std::clamp(camera.width / 8, 4, 16); }

struct View {
  const Scene& scene;
  const PinholeCamera& camera;
  Rigid3d world_from_camera;
  Eigen::Matrix3d rotation;  // world from camera

  Vector3d RayInWorld(double u, double v) const { return rotation * camera.Ray(u, v); }
};

View ViewFrom(const Scene& scene, const PinholeCamera& camera, const Rigid3d& world_from_camera) {
  return {scene, camera, world_from_camera, world_from_camera.rotation.toRotationMatrix()};
}

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

// Objects that rays of the tile can hit. The cone about the middle ray is convex and contains the
// four corner rays, so it contains all rays.
std::vector<RayCandidate> ObjectsInTile(const View& view, const Tile& tile) {
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

// Hits of the rays of the tile. Ray directions have z = 1 in the camera frame, so the ray parameter
// is the depth.
std::vector<PixelHit> TraceTile(const View& view, const Tile& tile) {
  const std::vector<RayCandidate> candidates = ObjectsInTile(view, tile);
  std::vector<PixelHit> hits;
  for (int v = tile.v_begin; v < tile.v_end; ++v) {
    for (int u = tile.u_begin; u < tile.u_end; ++u) {
      const auto hit = view.scene.Intersect(view.world_from_camera.translation,
                                            view.RayInWorld(u, v), candidates);
      if (hit) hits.push_back({u, v, *hit});
    }
  }
  return hits;
}

// Output images; empty images are not rendered.
struct SceneImages {
  Rendering rendering;
  LightImage light;
};

void DrawGeometry(const View& view, const std::vector<PixelHit>& hits, Rendering* rendering) {
  for (const auto& [u, v, hit] : hits) {
    rendering->depth_m(u, v) = static_cast<float>(hit.t);
    const Vector3d normal = view.rotation.transpose() * hit.normal_in_world;
    rendering->normal.Set(u, v, normal.cast<float>());
    rendering->surface(u, v) = Rendering::SurfaceOf(hit);
  }
}

void DrawTile(const View& view, const Tile& tile, SceneImages* images) {
  const std::vector<PixelHit> hits = TraceTile(view, tile);
  Rendering& rendering = images->rendering;
  if (!rendering.depth_m.empty()) DrawGeometry(view, hits, &rendering);
  if (rendering.color.empty() && images->light.empty()) return;
  std::vector<ScenePoint> points;
  points.reserve(hits.size());
  for (const auto& [u, v, hit] : hits) {
    points.push_back({hit, view.world_from_camera.translation + hit.t * view.RayInWorld(u, v)});
  }
  const std::vector<Vector3f> light = view.scene.Light(points);
  for (std::size_t i = 0; i < hits.size(); ++i) {
    const auto& [u, v, hit] = hits[i];
    if (!rendering.color.empty()) rendering.color(u, v) = ToSrgb(light[i]);
    if (!images->light.empty()) images->light(u, v) = light[i];
  }
}

Rendering BlankGeometry(const PinholeCamera& camera) {
  return {Image<float>(camera.width, camera.height, 0.f), Image<Rgb8>(),
          VectorImage(camera.width, camera.height),
          Image<std::int32_t>(camera.width, camera.height, Rendering::kNothing)};
}

void Draw(const Scene& scene, const PinholeCamera& camera, const Rigid3d& world_from_camera,
          SceneImages* images) {
  camera.Validate("camera");
  const View view = ViewFrom(scene, camera, world_from_camera);
  const std::vector<Tile> tiles = Tiles(camera);
  ParallelFor(0, static_cast<int>(tiles.size()), 8, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) DrawTile(view, tiles[i], images);
  });
}

// Tiles of 32 x 1 pixels, because each row has its own pose.
void DrawRows(const Scene& scene, const PinholeCamera& camera, const PoseOfRow& world_from_camera,
              SceneImages* images) {
  constexpr int kTile = 32;
  camera.Validate("camera");
  ParallelFor(0, camera.height, 4, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) {
      const View view = ViewFrom(scene, camera, world_from_camera(v));
      for (int u = 0; u < camera.width; u += kTile) {
        DrawTile(view, {u, std::min(u + kTile, camera.width), v, v + 1}, images);
      }
    }
  });
}

}  // namespace

Rendering Render(const Scene& scene, const PinholeCamera& camera,
                 const Rigid3d& world_from_camera) {
  SceneImages images = {BlankGeometry(camera), {}};
  images.rendering.color = Image<Rgb8>(camera.width, camera.height);
  Draw(scene, camera, world_from_camera, &images);
  return std::move(images.rendering);
}

Rendering RenderGeometry(const Scene& scene, const PinholeCamera& camera,
                         const Rigid3d& world_from_camera) {
  SceneImages images = {BlankGeometry(camera), {}};
  Draw(scene, camera, world_from_camera, &images);
  return std::move(images.rendering);
}

Rendering RenderRows(const Scene& scene, const PinholeCamera& camera,
                     const PoseOfRow& world_from_camera) {
  SceneImages images = {BlankGeometry(camera), {}};
  DrawRows(scene, camera, world_from_camera, &images);
  return std::move(images.rendering);
}

LightImage RenderLight(const Scene& scene, const PinholeCamera& camera,
                       const PoseOfRow& world_from_camera) {
  SceneImages images = {{}, LightImage(camera.width, camera.height, Vector3f::Zero())};
  DrawRows(scene, camera, world_from_camera, &images);
  return std::move(images.light);
}

Image<Rgb8> ToSrgbImage(const LightImage& light, const Vector3f& gains) {
  Image<Rgb8> color(light.width(), light.height());
  std::transform(light.begin(), light.end(), color.begin(),
                 [&](const Vector3f& l) { return ToSrgb(Vector3f(gains.cwiseProduct(l))); });
  return color;
}

RgbdFrame RenderFrame(const Scene& scene, const PinholeCamera& camera,
                      const Rigid3d& world_from_camera, int index, double stamp_s) {
  Rendering rendering = Render(scene, camera, world_from_camera);
  return {index, stamp_s, stamp_s, std::move(rendering.depth_m), std::move(rendering.color)};
}

}  // namespace surfit
