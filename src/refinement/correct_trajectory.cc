#include "surfit/refinement/correct_trajectory.h"

#include <glog/logging.h>

#include <algorithm>

#include "surfit/refinement/keyframe.h"

namespace surfit {
namespace {

std::vector<std::size_t> MovedPoses(const Trajectory& trajectory, double min_translation_m,
                                    double min_rotation_rad) {
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    if (chosen.empty() ||
        HasMoved(trajectory[chosen.back()].world_from_camera, trajectory[i].world_from_camera,
                 min_translation_m, min_rotation_rad)) {
      chosen.push_back(i);
    }
  }
  return chosen;
}

}  // namespace

std::vector<std::size_t> ChooseKeyframes(const Trajectory& trajectory, double min_translation_m,
                                         double min_rotation_rad, std::size_t max_count) {
  constexpr double kGrowth = 1.1;
  std::vector<std::size_t> chosen = MovedPoses(trajectory, min_translation_m, min_rotation_rad);
  while (max_count > 0 && chosen.size() > std::max<std::size_t>(max_count, 1)) {
    min_translation_m *= kGrowth;
    min_rotation_rad *= kGrowth;
    chosen = MovedPoses(trajectory, min_translation_m, min_rotation_rad);
  }
  return chosen;
}

Trajectory CorrectTrajectory(const Trajectory& trajectory,
                             const std::vector<std::size_t>& keyframes,
                             const std::vector<Rigid3d>& world_from_keyframe) {
  CHECK(!keyframes.empty() && keyframes.size() == world_from_keyframe.size());
  const auto moved = [&](std::size_t k, const Rigid3d& pose) {
    const Rigid3d& before = trajectory[keyframes[k]].world_from_camera;
    return world_from_keyframe[k] * (before.Inverse() * pose);
  };
  Trajectory corrected = trajectory;
  std::size_t k = 0;
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    while (k + 1 < keyframes.size() && keyframes[k + 1] <= i) ++k;
    const Rigid3d& pose = trajectory[i].world_from_camera;
    Rigid3d& result = corrected[i].world_from_camera;
    result = moved(k, pose);
    if (k + 1 == keyframes.size() || i <= keyframes[k]) continue;
    const double begin = trajectory[keyframes[k]].stamp_s;
    const double end = trajectory[keyframes[k + 1]].stamp_s;
    const double share = (trajectory[i].stamp_s - begin) / (end - begin);
    const Rigid3d next = moved(k + 1, pose);
    result.rotation = result.rotation.slerp(share, next.rotation).normalized();
    result.translation += share * (next.translation - result.translation);
  }
  return corrected;
}

}  // namespace surfit
