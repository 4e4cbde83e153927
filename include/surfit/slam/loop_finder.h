#pragma once

#include <functional>
#include <vector>

#include "surfit/places/find_loops.h"

namespace surfit {

// Tries to join keyframe `source` to earlier ones: FindLoops(), or another way.
using LoopFinder = std::function<std::vector<LoopAttempt>(
    int source, const std::vector<Keyframe>& keyframes, const PlaceIndex& index)>;

// A pair of keyframes that was tried as a loop, by the frames' indices.
struct LoopRecord {
  int source_frame = 0, target_frame = 0;
  LoopAttempt attempt;
  bool in_graph = false;  // accepted, and consistent with the others when last looked at
};

}  // namespace surfit
