#pragma once

#include "surfit/frame/frame_pyramid.h"

namespace surfit::testing {

// An 8 x 6 image with round numbers: u = 8 x/z + 3, v = 8 y/z + 2.
inline PinholeCamera TinyCamera() {
  PinholeCamera camera;
  camera.width = 8;
  camera.height = 6;
  camera.fx = camera.fy = 8;
  camera.cx = 3;
  camera.cy = 2;
  return camera;
}

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
