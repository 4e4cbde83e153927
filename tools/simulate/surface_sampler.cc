#include "simulate/surface_sampler.h"

#include <cmath>

namespace surfit::tools {

bool SurfaceSampler::IsFirstInItsCube(const Eigen::Vector3f& point_in_world) {
  // 21 bits per axis: with cubes of 5 mm, the range is 5 km in each direction.
  constexpr std::int64_t kOffset = 1 << 20;
  constexpr int kBits = 21;
  std::uint64_t key = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto cell =
        static_cast<std::int64_t>(std::floor(static_cast<double>(point_in_world[axis]) / grid_m_));
    key = (key << kBits) | static_cast<std::uint64_t>(cell + kOffset);
  }
  return taken_.insert(key).second;
}

void SurfaceSampler::Add(const Rendering& rendering, const Image<float>& measured_depth_m,
                         const PinholeCamera& camera, const PoseOfRow& world_from_camera) {
  for (int v = 0; v < camera.height; ++v) {
    const Rigid3d pose = world_from_camera(v);
    for (int u = 0; u < camera.width; ++u) {
      if (measured_depth_m(u, v) == 0 || rendering.depth_m(u, v) == 0) continue;
      const Eigen::Vector3d exact = pose * (rendering.depth_m(u, v) * camera.Ray(u, v));
      const Eigen::Vector3f point = exact.cast<float>();
      if (!IsFirstInItsCube(point)) continue;
      cloud_.points.push_back(point);
      cloud_.normals.push_back(pose.rotation.cast<float>() * rendering.normal(u, v));
      cloud_.colors.push_back(rendering.color(u, v));
    }
  }
}

void SurfaceSampler::Add(const PointCloud& cloud) {
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    if (!IsFirstInItsCube(cloud.points[i])) continue;
    cloud_.points.push_back(cloud.points[i]);
    cloud_.normals.push_back(cloud.normals[i]);
    cloud_.colors.push_back(cloud.colors[i]);
  }
}

}  // namespace surfit::tools
