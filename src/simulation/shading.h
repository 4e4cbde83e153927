#pragma once

#include <vector>

#include "surfit/core/image.h"
#include "surfit/simulation/scene.h"

namespace surfit {

struct SurfacePoint {
  SceneHit hit;
  Eigen::Vector3d point_in_world;
};

// The colours of points that lie near to each other: reflectance times light, the light being soft
// daylight from all around, brighter from above, and point lights with Lambert's law and shadows;
// a fixed exposure, sRGB.
std::vector<Rgb8> Shade(const Scene& scene, const std::vector<SurfacePoint>& points);

}  // namespace surfit
