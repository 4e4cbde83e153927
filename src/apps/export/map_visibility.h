#pragma once

#include <Eigen/Core>

#include "apps/export/color_images.h"
#include "surfit/core/image.h"
#include "surfit/mapping/model_renderer.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

// Depth of the map as seen by the colour camera, without lens distortion. Not thread-safe.
class MapDepth {
 public:
  // Keeps a reference to the map. `lens`: colour camera. Rendered images have 1 to 2 times
  // `columns` columns plus a margin, and at most the resolution of `lens`.
  MapDepth(const SurfelMap& map, const PinholeCamera& lens, int columns);

  // Renders the map at a pose of the colour camera. Call before IsVisible() and depth_m().
  void Render(const Rigid3d& world_from_color);
  // True if the surface at the point faces the camera (within 80 degrees, depth above 5 cm) and
  // nothing occludes the point. Points next to depth edges, next to pixels without depth, and
  // outside the image are not visible. `point` (m) and `normal` (unit length, towards the observed
  // side) are in the frame of the camera.
  bool IsVisible(const Eigen::Vector3d& point, const Eigen::Vector3d& normal) const;

  // Camera of depth_m(), with margin.
  const PinholeCamera& camera() const { return sensor_.camera; }
  const Image<float>& depth_m() const { return depth_m_; }  // 0: no surface

 private:
  const SurfelMap& map_;
  DepthSensor sensor_;
  ModelRenderer renderer_;
  Image<float> depth_m_;
};

}  // namespace surfit
