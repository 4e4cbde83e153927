#pragma once

#include <optional>
#include <vector>

#include "surfit/frame/preprocess.h"
#include "surfit/loop_closure/keyframe.h"
#include "surfit/loop_closure/place_index.h"
#include "surfit/poses/pose_store.h"
#include "surfit/registration/far_registration.h"

namespace surfit {

class OptionVisitor;

// How a loop is verified.
struct VerifyLoopOptions {
  PreprocessOptions preprocess;  // of the views' normals and coarser levels
  IcpOptions icp = DefaultIcp();
  int min_agreeing_features = 12;  // for a pose that features propose
  FitCriteria fit;

  // Symmetric residual, from a coarse level within the reach of what starts it.
  static IcpOptions DefaultIcp();

  void Visit(OptionVisitor& visitor);
};

// Registers one view of a place to another and judges the fit: poses that features agree on and, if
// given, a prior are refined densely on a coarse level, the best on the finest. Throws InputError
// for impossible options; a loop that is not believed is a verdict, not an error. The same bit for
// bit at any number of threads.
FarVerdict VerifyLoop(const PlaceView& source, const PlaceView& target,
                      const VerifyLoopOptions& options,
                      const std::optional<Rigid3d>& target_from_source_prior = std::nullopt);

// Which pairs of keyframes are verified.
struct FindLoopsOptions {
  int min_gap = 100;           // frames between the two
  int max_alike = 3;           // keyframes that look most alike
  int max_near = 2;            // further ones whose estimated poses are nearest
  double max_near_m = 0.5;     // near is no farther than this,
  double max_near_rad = 0.52;  // nor turned by more: 30 degrees
  VerifyLoopOptions verify;

  void Visit(OptionVisitor& visitor);
};

// Earlier keyframes to which keyframe `source` may be joined: those most alike first, then those
// that are near. The index knows keyframes by their positions.
std::vector<LoopProposal> ProposeLoops(int source, const std::vector<Keyframe>& keyframes,
                                       const PlaceIndex& index, const FindLoopsOptions& options);

// Verifies all proposals, in their order. Throws InputError for impossible options.
std::vector<LoopAttempt> FindLoops(int source, const std::vector<Keyframe>& keyframes,
                                   const PlaceIndex& index, const FindLoopsOptions& options);

// How a lost camera is found again.
struct RelocalizeOptions {
  int max_candidates = 5;  // keyframes that are tried, those most alike first
  VerifyLoopOptions verify;

  void Visit(OptionVisitor& visitor);
};

// Where a camera was found, or why not.
struct Relocalization {
  static constexpr int kNone = -1;

  int keyframe = kNone;               // position of the one it was found by
  Rigid3d world_from_camera;          // by that keyframe's pose; meaningless if there is none
  std::vector<LoopAttempt> attempts;  // their source is kNone; the last may be accepted

  bool found() const { return keyframe != kNone; }
};

// Looks for the view among the keyframes, without any prior pose: the first that looks alike and is
// verified.
Relocalization Relocalize(const PlaceView& view, const std::vector<Keyframe>& keyframes,
                          const PlaceIndex& index, const RelocalizeOptions& options);

}  // namespace surfit
