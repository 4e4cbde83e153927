#pragma once

#include <cstdint>
#include <unordered_set>

#include "surfit/geometry/pinhole_camera.h"
#include "surfit/io/point_cloud.h"
#include "surfit/simulation/render.h"

namespace surfit::tools {

// Collects points of the exact surface that a sensor observed, in the world frame: the first point
// in each cube of a grid. Points have normals and colours. Requires `grid_m` > 0 and coordinates
// below 2^20 grid_m.
class SurfaceSampler {
 public:
  explicit SurfaceSampler(double grid_m) : grid_m_(grid_m) {}

  // Adds the exact points of `rendering` at pixels with a measurement (not 0). All images have the
  // size of `camera`. Needs the normals and the colour image. Each row has its own pose.
  void Add(const Rendering& rendering, const Image<float>& measured_depth_m,
           const PinholeCamera& camera, const PoseOfRow& world_from_camera);
  // Adds the points of another sampler with the same grid. The result is the same as if its
  // renderings were added to this sampler.
  void Add(const PointCloud& cloud);

  const PointCloud& cloud() const { return cloud_; }

 private:
  bool IsFirstInItsCube(const Eigen::Vector3f& point_in_world);

  double grid_m_;
  std::unordered_set<std::uint64_t> taken_;
  PointCloud cloud_;
};

}  // namespace surfit::tools
