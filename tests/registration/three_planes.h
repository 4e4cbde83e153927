#pragma once

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "surfit/frame/frame_pyramid.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/registration/pose_solver.h"
#include "testing/pixels.h"

namespace surfit::testing {

inline std::vector<std::string> PointToPlaneSolverNames() {
  std::vector<std::string> names = PoseSolverNames();
  names.erase(std::find(names.begin(), names.end(), "svd"));
  return names;
}

inline PinholeCamera CornerCamera() { return {160, 120, 131.3, 130.1, 79.3, 60.2, {}}; }

// Camera pose at 1.9 m from the corner of three planes, all in view.
inline Rigid3d PoseBeforeTheCorner() {
  const Eigen::Vector3d eye(1.3, 1.0, 0.9);
  const Eigen::Vector3d z = -eye.normalized();
  const Eigen::Vector3d x = z.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d world_from_camera;
  world_from_camera << x, z.cross(x), z;
  return {world_from_camera, eye};
}

// Exact vertices and normals of the planes x = 0, y = 0 and z = 0, rounded to float once. Only the
// first `planes` planes exist.
inline FrameLevel RenderCorner(const Rigid3d& world_from_camera, int planes = 3) {
  FrameLevel level;
  level.camera = CornerCamera();
  level.vertex = VectorImage(level.camera.width, level.camera.height);
  level.normal = VectorImage(level.camera.width, level.camera.height);
  const Eigen::Matrix3d rotation = world_from_camera.rotation.toRotationMatrix();
  for (const auto [u, v] : PixelsOf(level.camera)) {
    const Eigen::Vector3d ray = rotation * level.camera.Ray(u, v);
    double depth_m = std::numeric_limits<double>::infinity();
    int nearest = -1;
    for (int i = 0; i < planes; ++i) {
      const double t = -world_from_camera.translation[i] / ray[i];
      if (t > 0 && t < depth_m) depth_m = t, nearest = i;
    }
    if (nearest < 0) continue;
    level.vertex.Set(u, v, (depth_m * level.camera.Ray(u, v)).cast<float>());
    level.normal.Set(u, v, rotation.row(nearest).transpose().cast<float>());  // into the room
  }
  return level;
}

inline FramePyramid OneLevel(FrameLevel level) {
  FramePyramid pyramid;
  pyramid.levels.push_back(std::move(level));
  return pyramid;
}

// 8 x 6 image with round parameters: u = 8 x/z + 3, v = 8 y/z + 2.
inline PinholeCamera TinyCamera() { return {8, 6, 8, 8, 3, 2, {}}; }

inline FrameLevel EmptyLevel() {
  FrameLevel level;
  level.camera = TinyCamera();
  level.vertex = VectorImage(level.camera.width, level.camera.height);
  level.normal = VectorImage(level.camera.width, level.camera.height);
  return level;
}

inline void SetPoint(FrameLevel* level, int u, int v, double depth_m,
                     const Eigen::Vector3d& normal) {
  level->vertex.Set(u, v, (depth_m * level->camera.Ray(u, v)).cast<float>());
  level->normal.Set(u, v, normal.cast<float>());
}

}  // namespace surfit::testing
