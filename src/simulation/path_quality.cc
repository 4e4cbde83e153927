#include "simulation/path_quality.h"

#include <algorithm>
#include <functional>
#include <map>
#include <vector>

#include "surfit/simulation/render.h"

namespace surfit {
ViewQuality JudgeView(const Scene& scene, const Rigid3d& world_from_camera) {
  PinholeCamera camera;  // every 32nd pixel
  camera.width = 20;
  camera.height = 15;
  camera.fx = camera.fy = 525.0 / 32;
  camera.cx = 9.5;
  camera.cy = 7;
  const Rendering image = RenderGeometry(scene, camera, world_from_camera);
  int seen = 0;
  std::map<std::int32_t, int> pixels_on_face;
  for (std::size_t i = 0; i < image.depth_m.size(); ++i) {
    if (image.depth_m[i] < 0.4f || image.depth_m[i] > 4.5f) continue;
    ++seen;
    if (Rendering::IsFlat(image.surface[i])) ++pixels_on_face[image.surface[i]];
  }
  std::vector<int> largest(2, 0);
  for (const auto& [face, pixels] : pixels_on_face) largest.push_back(pixels);
  std::partial_sort(largest.begin(), largest.begin() + 2, largest.end(), std::greater<int>());
  return {static_cast<double>(seen) / image.depth_m.size(),
          static_cast<double>(largest[0] + largest[1]) / std::max(1, seen)};
}

PathQuality JudgePath(const Scene& scene, const Trajectory& path) {
  constexpr std::size_t kFramesApart = 10;
  PathQuality quality;
  int views = 0, planar = 0, bare = 0;
  for (std::size_t i = 0; i < path.size(); i += kFramesApart, ++views) {
    const ViewQuality view = JudgeView(scene, path[i].world_from_camera);
    if (view.IsPlanar()) ++planar;
    if (view.IsBare()) ++bare;
  }
  quality.planar_share = static_cast<double>(planar) / views;
  quality.bare_share = static_cast<double>(bare) / views;
  return quality;
}

}  // namespace surfit
