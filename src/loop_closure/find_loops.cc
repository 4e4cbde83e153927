#include "surfit/loop_closure/find_loops.h"

#include <algorithm>

#include "surfit/core/options.h"

namespace surfit {

namespace {

// Number of keyframes that RelocalizeOptions::first_candidate can select.
constexpr int kMaxRanked = 5;

struct Neighbour {
  int keyframe;
  double relative_distance;  // distance / kMaxNear_m or angle / kMaxNear_rad, the larger value
  Rigid3d target_from_source;
};

std::vector<Neighbour> Neighbours(int source, const std::vector<Keyframe>& keyframes) {
  std::vector<Neighbour> neighbours;
  for (int target = 0; target < source; ++target) {
    if (keyframes[target].piece != keyframes[source].piece) continue;
    const Rigid3d motion =
        keyframes[target].world_from_camera.Inverse() * keyframes[source].world_from_camera;
    const double relative_distance =
        std::max(motion.translation.norm() / FindLoopsOptions::kMaxNear_m,
                 RotationAngle(motion.rotation) / FindLoopsOptions::kMaxNear_rad);
    if (relative_distance <= 1) neighbours.push_back({target, relative_distance, motion});
  }
  std::stable_sort(neighbours.begin(), neighbours.end(), [](const auto& a, const auto& b) {
    return a.relative_distance < b.relative_distance;
  });
  return neighbours;
}

}  // namespace

std::vector<LoopCandidate> ProposeLoopCandidates(int source, const std::vector<Keyframe>& keyframes,
                                                 const PlaceIndex& index,
                                                 const FindLoopsOptions& options) {
  const auto is_wanted = [&](int keyframe) {
    const bool is_other_piece = keyframes[keyframe].piece != keyframes[source].piece;
    return !keyframes[keyframe].view.empty() &&
           (is_other_piece ||
            keyframes[source].frame_index - keyframes[keyframe].frame_index >= options.min_gap);
  };
  std::vector<LoopCandidate> proposals;
  for (const PlaceCandidate& candidate :
       index.Query(keyframes[source].view, options.max_similar, is_wanted)) {
    proposals.push_back({source, candidate.keyframe, candidate.similarity, std::nullopt});
  }
  int near_count = 0;
  for (const Neighbour& neighbour : Neighbours(source, keyframes)) {
    const auto known =
        std::find_if(proposals.begin(), proposals.end(),
                     [&](const LoopCandidate& p) { return p.target == neighbour.keyframe; });
    if (known != proposals.end()) {
      known->target_from_source_prior = neighbour.target_from_source;
    } else if (near_count < options.max_near && is_wanted(neighbour.keyframe)) {
      proposals.push_back({source, neighbour.keyframe, 0, neighbour.target_from_source});
      ++near_count;
    }
  }
  return proposals;
}

std::vector<LoopVerification> FindLoops(int source, const std::vector<Keyframe>& keyframes,
                                        const PlaceIndex& index, const FindLoopsOptions& options) {
  Validate(options);
  std::vector<LoopVerification> attempts;
  for (const LoopCandidate& proposal : ProposeLoopCandidates(source, keyframes, index, options)) {
    const GlobalRegistrationResult verdict =
        VerifyLoop(keyframes[source].view, keyframes[proposal.target].view, options.verify,
                   proposal.target_from_source_prior);
    attempts.push_back({proposal, verdict});
  }
  return attempts;
}

Relocalization Relocalize(const PlaceView& view, const std::vector<Keyframe>& keyframes,
                          const PlaceIndex& index, const RelocalizeOptions& options) {
  Validate(options);
  Relocalization result;
  const auto has_view = [&](int keyframe) { return !keyframes[keyframe].view.empty(); };
  std::vector<PlaceCandidate> candidates =
      index.Query(view, std::max(options.max_candidates, kMaxRanked), has_view);
  if (candidates.empty()) return result;
  const std::size_t first = options.first_candidate % candidates.size();
  const std::size_t end = std::min(candidates.size(), first + options.max_candidates);
  for (std::size_t i = first; i < end; ++i) {
    const PlaceCandidate& candidate = candidates[i];
    const Keyframe& keyframe = keyframes[candidate.keyframe];
    const GlobalRegistrationResult verdict = VerifyLoop(view, keyframe.view, options.verify);
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
