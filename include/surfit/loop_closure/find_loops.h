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

// Options of VerifyLoop().
struct VerifyLoopOptions {
  PreprocessOptions preprocess;  // for normals and pyramids of the views
  IcpOptions icp = DefaultIcp();
  int min_agreeing_features = 12;  // of an initial pose from features
  FitCriteria fit;

  // Symmetric point-to-plane residual with a gate of 5 cm and 0.5 rad, and photometric residuals.
  static IcpOptions DefaultIcp();

  void Visit(OptionVisitor& visitor);
};

// Registers `source` to `target` and verifies the result. Initial poses come from feature
// correspondences and from the prior, if there is one. They are refined by ICP on a coarse level,
// and the best pose on the finest level. A rejected candidate is a GlobalRegistrationResult with
// its reason, not an error. The result is bitwise identical for any number of threads. Throws
// InputError for invalid options.
GlobalRegistrationResult VerifyLoop(
    const PlaceView& source, const PlaceView& target, const VerifyLoopOptions& options,
    const std::optional<Rigid3d>& target_from_source_prior = std::nullopt);

// Options of the search for loop candidates.
struct FindLoopsOptions {
  int min_gap = 100;           // minimum difference of the frame indices
  int max_similar = 3;         // maximum number of candidates from place recognition
  int max_near = 2;            // maximum number of additional candidates with a near estimated pose
  double max_near_m = 0.5;     // maximum distance of a near pose
  double max_near_rad = 0.52;  // maximum rotation of a near pose: 30 degrees
  VerifyLoopOptions verify;

  void Visit(OptionVisitor& visitor);
};

// Returns loop candidates between keyframe `source` and earlier keyframes: first by descending
// similarity, then by increasing pose distance. `source` and the keyframes of the index are
// positions in `keyframes`.
std::vector<LoopCandidate> ProposeLoopCandidates(int source, const std::vector<Keyframe>& keyframes,
                                                 const PlaceIndex& index,
                                                 const FindLoopsOptions& options);

// Verifies all candidates of ProposeLoopCandidates(), in their order. Throws InputError for invalid
// options.
std::vector<LoopVerification> FindLoops(int source, const std::vector<Keyframe>& keyframes,
                                        const PlaceIndex& index, const FindLoopsOptions& options);

// Options of Relocalize().
struct RelocalizeOptions {
  int max_candidates = 5;  // maximum number of keyframes to verify, by descending similarity
  VerifyLoopOptions verify;

  void Visit(OptionVisitor& visitor);
};

// Result of Relocalize().
struct Relocalization {
  static constexpr int kNone = -1;

  int keyframe = kNone;       // position of the matching keyframe; kNone: not found
  Rigid3d world_from_camera;  // from the pose of this keyframe; undefined if not found
  // Verified candidates in their order, with source kNone. If there is a match, it is the last
  // element.
  std::vector<LoopVerification> attempts;

  bool found() const { return keyframe != kNone; }
};

// Relocalises a view without a prior pose: returns the first candidate of place recognition that is
// verified. Throws InputError for invalid options.
Relocalization Relocalize(const PlaceView& view, const std::vector<Keyframe>& keyframes,
                          const PlaceIndex& index, const RelocalizeOptions& options);

}  // namespace surfit
