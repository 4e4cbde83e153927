#pragma once

#include "surfit/geometry/pinhole_camera.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/mapping/surfel_map.h"
#include "surfit/simulation/render.h"

namespace surfit::testing {

// Appends a surfel for every `stride`-th row and column of a rendering with depth.
inline void AddSurfels(const Rendering& seen, const PinholeCamera& camera,
                       const Rigid3d& world_from_camera, int stride, SurfelMap* map) {
  for (int v = 0; v < camera.height; v += stride) {
    for (int u = 0; u < camera.width; u += stride) {
      const float depth_m = seen.depth_m(u, v);
      if (!(depth_m > 0)) continue;
      Surfel surfel;
      surfel.position_in_world = (world_from_camera * (depth_m * camera.Ray(u, v))).cast<float>();
      surfel.normal_in_world = (world_from_camera.rotation * seen.normal(u, v).cast<double>())
                                   .cast<float>()
                                   .normalized();
      surfel.radius_m = 1.4f * stride * depth_m / static_cast<float>(camera.fx);
      surfel.confidence = 20;
      map->Append(surfel);
    }
  }
}

}  // namespace surfit::testing
