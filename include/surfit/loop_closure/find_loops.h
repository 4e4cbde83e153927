#pragma once

#include <optional>
#include <vector>

#include "surfit/frame/preprocess.h"
#include "surfit/loop_closure/keyframe.h"
#include "surfit/loop_closure/place_index.h"
#include "surfit/poses/pose_store.h"
#include "surfit/registration/global_registration.h"

namespace surfit {

class OptionVisitor;

// Verification of loop candidates, and relocalisation. The functions keep no references, and
// concurrent calls are safe.

// Options of VerifyLoop().
struct VerifyLoopOptions {
  PreprocessOptions preprocess;  // normals and pyramids of the views
  IcpOptions icp = DefaultIcp();
  FitCriteria fit;

  // Symmetric point-to-plane and photometric residuals, with a gate of 5 cm and 0.5 rad.
  static IcpOptions DefaultIcp();

  void Visit(OptionVisitor& visitor);
};

// Registers `source` to `target` and verifies the result. Initial poses come from feature
// correspondences with at least 12 inliers, and from the optional prior. All are refined on a
// coarse level, and the best pose on the finest level. The result states success, or the reason for
// rejection. It is bitwise identical for any number of threads. An empty view gives kNoView.
// Without enough inlier features and without a prior, the reason is kNoStart. Throws InputError for
// invalid options.
GlobalRegistrationResult VerifyLoop(
    const PlaceView& source, const PlaceView& target, const VerifyLoopOptions& options,
    const std::optional<Rigid3d>& target_from_source_prior = std::nullopt);

// Options of FindLoops(). Distances are those of the current pose estimates.
struct FindLoopsOptions {
  // Maximum distance and rotation (30 degrees) of additional candidates.
  static constexpr double kMaxNear_m = 0.5, kMaxNear_rad = 0.52;

  int min_gap = 100;    // minimum difference of the frame indices within a piece
  int max_similar = 3;  // maximum number of candidates from place recognition
  int max_near = 2;     // maximum number of additional candidates by pose; 0: none
  VerifyLoopOptions verify;

  void Visit(OptionVisitor& visitor);
};

// Returns loop candidates of keyframe `source` among the earlier keyframes. `source` and the
// numbers in `index` are positions in `keyframes`, which is not checked. Candidates of place
// recognition come first, by descending similarity. Candidates by pose follow, by ascending
// distance: the larger ratio to kMaxNear_m or kMaxNear_rad. A candidate of place recognition within
// these limits also gets the prior. Keyframes with an empty view are not candidates. Empty without
// candidates.
std::vector<LoopCandidate> ProposeLoopCandidates(int source, const std::vector<Keyframe>& keyframes,
                                                 const PlaceIndex& index,
                                                 const FindLoopsOptions& options);

// Verifies all candidates of ProposeLoopCandidates(), also after a success, in their order.
// `source` is a position in `keyframes`. Rejected candidates are included. Throws InputError for
// invalid options.
std::vector<LoopVerification> FindLoops(int source, const std::vector<Keyframe>& keyframes,
                                        const PlaceIndex& index, const FindLoopsOptions& options);

// Options of Relocalize().
struct RelocalizeOptions {
  int max_candidates = 5;  // maximum number of verified keyframes, by descending similarity
  // Rank of the first verified keyframe, modulo the number of similar keyframes. Other values than
  // 0 spread the candidates over several frames.
  int first_candidate = 0;
  VerifyLoopOptions verify;

  void Visit(OptionVisitor& visitor);
};

// Result of Relocalize().
struct Relocalization {
  static constexpr int kNone = -1;

  int keyframe = kNone;       // position of the matching keyframe; kNone: not found
  Rigid3d world_from_camera;  // pose by registration to this keyframe; identity if not found
  // Verified candidates in their order, with source kNone. The match, if any, is the last element.
  std::vector<LoopVerification> attempts;

  bool found() const { return keyframe != kNone; }
};

// Relocalises a view without a prior pose. Numbers in `index` are positions in `keyframes`.
// Candidates of place recognition are verified until the first success. A view without features has
// no candidates. Throws InputError for invalid options.
Relocalization Relocalize(const PlaceView& view, const std::vector<Keyframe>& keyframes,
                          const PlaceIndex& index, const RelocalizeOptions& options);

}  // namespace surfit
