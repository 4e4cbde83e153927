#include "surfit/places/limit_keyframes.h"

#include <utility>

namespace surfit {
namespace {

// Weighs turns as way: at about 2 m, where things are.
double Difference(const Keyframe& a, const Keyframe& b) {
  constexpr double kDistanceM = 2;
  const Rigid3d motion = a.world_from_camera.Inverse() * b.world_from_camera;
  return motion.translation.norm() + kDistanceM * RotationAngle(motion.rotation);
}

std::vector<int> WithViews(const std::vector<Keyframe>& keyframes) {
  std::vector<int> positions;
  for (int i = 0; i < static_cast<int>(keyframes.size()); ++i) {
    if (!keyframes[i].view.empty()) positions.push_back(i);
  }
  return positions;
}

// The older of the two that are most alike. Of none or one, that.
int LeastMissed(const std::vector<Keyframe>& keyframes, const std::vector<int>& positions) {
  int least = positions.front();
  double least_difference = -1;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    for (std::size_t j = i + 1; j < positions.size(); ++j) {
      const double difference = Difference(keyframes[positions[i]], keyframes[positions[j]]);
      if (least_difference >= 0 && difference >= least_difference) continue;
      least_difference = difference;
      least = positions[i];
    }
  }
  return least;
}

}  // namespace

std::vector<int> LimitKeyframes(std::size_t max_bytes, std::vector<Keyframe>* keyframes,
                                PlaceIndex* index) {
  std::size_t bytes = 0;
  for (const Keyframe& keyframe : *keyframes) bytes += keyframe.view.Bytes();
  std::vector<int> given_up;
  while (bytes > max_bytes) {
    const int position = LeastMissed(*keyframes, WithViews(*keyframes));
    bytes -= (*keyframes)[position].view.Bytes();
    (*keyframes)[position].view = PlaceView();
    index->Remove(position);
    given_up.push_back(position);
  }
  return given_up;
}

}  // namespace surfit
