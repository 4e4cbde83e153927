#pragma once

#include <vector>

#include "surfit/places/find_loops.h"

namespace surfit {

class OptionVisitor;

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
