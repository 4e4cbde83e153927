#include "surfit/places/relocalize.h"

#include "surfit/core/error.h"
#include "surfit/core/options.h"

namespace surfit {

Relocalization Relocalize(const PlaceView& view, const std::vector<Keyframe>& keyframes,
                          const PlaceIndex& index, const RelocalizeOptions& options) {
  Validate(options);
  Relocalization result;
  const auto has_view = [&](int keyframe) { return !keyframes[keyframe].view.empty(); };
  for (const PlaceCandidate& candidate : index.Query(view, options.max_candidates, has_view)) {
    const Keyframe& keyframe = keyframes[candidate.keyframe];
    const FarVerdict verdict = VerifyLoop(view, keyframe.view, options.verify);
    result.attempts.push_back(
        {{Relocalization::kNone, candidate.keyframe, candidate.similarity, std::nullopt}, verdict});
    if (!verdict.accepted()) continue;
    result.keyframe = candidate.keyframe;
    result.world_from_camera = keyframe.world_from_camera * verdict.target_from_source;
    break;
  }
  return result;
}

}  // namespace surfit
