#include "apps/scan/link_truth.h"

#include <algorithm>

#include "surfit/geometry/trajectory.h"

namespace surfit {
namespace {

std::optional<Rigid3d> TruthOf(const Trajectory& ground_truth, const RunPlaces& places,
                               int keyframe) {
  const int index = places.keyframes[keyframe].frame_index;
  const auto frame =
      std::lower_bound(places.frames.begin(), places.frames.end(), index,
                       [](const PosedFrame& other, int i) { return other.index < i; });
  if (frame == places.frames.end() || frame->index != index) return std::nullopt;
  const MatchOptions match;
  return InterpolatePose(ground_truth, frame->stamp_s, match.max_gap_s, match.max_difference_s);
}

}  // namespace

std::optional<PoseError> ErrorOfLink(const Trajectory& ground_truth, const RunPlaces& source,
                                     int source_keyframe, const RunPlaces& target,
                                     int target_keyframe, const Rigid3d& target_from_source) {
  const std::optional<Rigid3d> from = TruthOf(ground_truth, source, source_keyframe),
                               to = TruthOf(ground_truth, target, target_keyframe);
  if (!from || !to) return std::nullopt;
  return ErrorOf(target_from_source, to->Inverse() * *from);
}

void UpdateMaximum(const std::optional<PoseError>& error, std::optional<PoseError>* worst) {
  if (!error || (*worst && (*worst)->translation_m >= error->translation_m)) return;
  *worst = error;
}

}  // namespace surfit
