#include <algorithm>

#include "surfit/loop_closure/keyframe.h"

namespace surfit {
namespace {

constexpr int kStridePx = 8;
// A point is occluded if its depth exceeds the surface depth by this ratio.
constexpr double kHiddenRatio = 0.1;
// Minimum motion for a new keyframe because of overlap or number of frames. The motion is relative
// to `max_distance_m` and `max_angle_rad`.
constexpr double kLittleMotion = 0.1;

bool IsSeen(const Eigen::Vector3d& point, const FrameLevel& surface) {
  if (!(point.z() > 0)) return false;
  const Eigen::Vector2d pixel = surface.camera.Project(point).array().round();
  if (!(pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() < surface.camera.width &&
        pixel.y() < surface.camera.height)) {
    return false;
  }
  const float depth_m = surface.vertex.z(static_cast<int>(pixel.x()), static_cast<int>(pixel.y()));
  return !(depth_m > 0) || point.z() < (1 + kHiddenRatio) * depth_m;
}

}  // namespace

double OverlapRatio(const Keyframe& keyframe, const FrameLevel& surface,
                    const Rigid3d& world_from_camera) {
  const PlaceView& view = keyframe.view;
  const Rigid3d camera_from_keyframe = world_from_camera.Inverse() * keyframe.world_from_camera;
  int seen = 0, all = 0;
  for (int v = 0; v < view.depth.height(); v += kStridePx) {
    for (int u = 0; u < view.depth.width(); u += kStridePx) {
      if (view.depth(u, v) == 0) continue;
      const double depth_m = view.depth(u, v) / PlaceView::kDepthUnitsPerMetre;
      ++all;
      seen += IsSeen(camera_from_keyframe * (view.camera.Ray(u, v) * depth_m), surface);
    }
  }
  return all > 0 ? static_cast<double>(seen) / all : 0;
}

bool IsKeyframe(const Keyframe& last, int frame_index, const FrameLevel& surface,
                const Rigid3d& world_from_camera, const KeyframeOptions& options) {
  const Rigid3d motion = last.world_from_camera.Inverse() * world_from_camera;
  const double distance = motion.translation.norm() / options.max_distance_m;
  const double angle = RotationAngle(motion.rotation) / options.max_angle_rad;
  const double moved = std::max(distance, angle);
  if (moved >= 1) return true;
  if (moved < kLittleMotion) return false;
  if (frame_index - last.frame_index >= options.max_frames) return true;
  return !last.view.empty() &&
         OverlapRatio(last, surface, world_from_camera) < options.min_overlap_ratio;
}

}  // namespace surfit
