#include "surfit/frame/camera_motion.h"

#include <algorithm>

namespace surfit {

CameraMotion MotionOver(const Rigid3d& first_from_second, double seconds) {
  if (!(seconds > 0)) return {};
  const Eigen::Vector3d turn = QuaternionLog(first_from_second.rotation);
  const Eigen::Vector3d way = QuaternionExp<double>(-0.5 * turn) * first_from_second.translation;
  return {turn / seconds, way / seconds};
}

CameraMotion MotionAt(const Trajectory& trajectory, double stamp_s, double max_gap_s) {
  constexpr double kSameStamp = 1e-5;  // s; files round timestamps to 6 decimals
  const auto at =
      std::lower_bound(trajectory.begin(), trajectory.end(), stamp_s - kSameStamp,
                       [](const StampedPose& pose, double stamp) { return pose.stamp_s < stamp; });
  if (at == trajectory.end() || at->stamp_s > stamp_s + kSameStamp) return {};
  auto first = at, last = at;
  if (at != trajectory.begin() && at->stamp_s - std::prev(at)->stamp_s <= max_gap_s) --first;
  if (std::next(at) != trajectory.end() && std::next(at)->stamp_s - at->stamp_s <= max_gap_s)
    ++last;
  return MotionOver(first->world_from_camera.Inverse() * last->world_from_camera,
                    last->stamp_s - first->stamp_s);
}

}  // namespace surfit
