#include "mapping/map/view_frustum.h"

namespace surfit {

ViewFrustum::ViewFrustum(const PosedCamera& camera, float margin_px)
    : camera_position_norm_(camera.world_translation.lpNorm<1>()) {
  const float margin = margin_px + 0.01f;
  const float width = static_cast<float>(camera.width), height = static_cast<float>(camera.height);
  // A point (x, y, z) is inside if -margin <= fx x / z + cx <= width + margin. The vertical bounds
  // are analogous.
  const Eigen::Vector3f in_camera[] = {{0, 0, 1},
                                       {camera.fx, 0, camera.cx + margin},
                                       {-camera.fx, 0, width + margin - camera.cx},
                                       {0, camera.fy, camera.cy + margin},
                                       {0, -camera.fy, height + margin - camera.cy}};
  for (std::size_t i = 0; i < planes_.size(); ++i) {
    const Eigen::Vector3f inwards = camera.world_rotation * in_camera[i].normalized();
    const float depth = i == 0 ? kMinDepth : 0.f;
    planes_[i] = {inwards, inwards.dot(camera.world_translation) + depth};
  }
}

std::vector<std::int32_t> VisibleCells(const SurfelMap& map, const ViewFrustum& frustum) {
  std::vector<std::int32_t> visible;
  for (std::int32_t i = 0; i < map.cell_count(); ++i) {
    const SurfelBounds& bounds = map.cell(i).bounds;
    if (!bounds.empty() && frustum.MaySee(bounds)) visible.push_back(i);
  }
  return visible;
}

}  // namespace surfit
