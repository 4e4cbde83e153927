#pragma once

#include <Eigen/Core>
#include <vector>

#include "apps/export/color_images.h"
#include "surfit/core/image.h"
#include "surfit/mapping/model_renderer.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

// Surfels that are treated as part of a surface, not as noise: NoiseConfidence(). In the order of
// SurfelMap::Ids(), with finite positions.
std::vector<Surfel> ReliableSurfels(const SurfelMap& map);

// Depth of the map as seen by the colour camera, without lens distortion.
class MapDepth {
 public:
  // `columns`: approximate number of columns of the rendered depth.
  MapDepth(const SurfelMap& map, const PinholeCamera& lens, int columns);

  void Render(const Rigid3d& world_from_color);
  // True if the surface at the point faces the camera and nothing occludes the point. Points next
  // to depth edges are not visible. `point` and `normal` are in the frame of the camera.
  bool IsVisible(const Eigen::Vector3d& point, const Eigen::Vector3d& normal) const;

  const PinholeCamera& camera() const { return sensor_.camera; }
  const Image<float>& depth_m() const { return depth_m_; }

 private:
  const SurfelMap& map_;
  DepthSensor sensor_;
  ModelRenderer renderer_;
  Image<float> depth_m_;
};

}  // namespace surfit
