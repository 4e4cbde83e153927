#pragma once

#include <cstdint>
#include <unordered_set>

#include "surfit/geometry/pinhole_camera.h"
#include "surfit/io/point_cloud.h"
#include "surfit/simulation/render.h"

namespace surfit::tools {

// Collects points of the exact surface that a sensor saw, in the world's frame: the first to fall
// into each cube of a grid.
class SurfaceSampler {
 public:
  explicit SurfaceSampler(double grid_m) : grid_m_(grid_m) {}

  // Adds what is exact in `rendering` where the sensor measured anything, each row by its pose.
  void Add(const Rendering& rendering, const Image<float>& measured_depth_m,
           const PinholeCamera& camera, const PoseOfRow& world_from_camera);
  // What another one of the same grid has collected: as if all had been added here.
  void Add(const PointCloud& cloud);

  const PointCloud& cloud() const { return cloud_; }

 private:
  bool IsFirstInItsCube(const Eigen::Vector3f& point_in_world);

  double grid_m_;
  std::unordered_set<std::uint64_t> taken_;
  PointCloud cloud_;
};

}  // namespace surfit::tools
