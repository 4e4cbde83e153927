#pragma once

#include <optional>
#include <vector>

#include "surfit/places/place_index.h"
#include "surfit/places/verify_loop.h"

namespace surfit {

class OptionVisitor;

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

// Two keyframes that may show one place; source is the later one.
struct LoopProposal {
  int source = 0, target = 0;  // positions in the list of keyframes
  double similarity = 0;       // by the index; 0 where it was proposed by its pose alone
  std::optional<Rigid3d> target_from_source_prior;  // by the estimated poses, where near
};

// A proposal that was verified.
struct LoopAttempt {
  LoopProposal proposal;
  FarVerdict verdict;
};

// Earlier keyframes to which keyframe `source` may be joined: those most alike first, then those
// that are near. The index knows keyframes by their positions.
std::vector<LoopProposal> ProposeLoops(int source, const std::vector<Keyframe>& keyframes,
                                       const PlaceIndex& index, const FindLoopsOptions& options);

// Verifies all proposals, in their order. Throws InputError for impossible options.
std::vector<LoopAttempt> FindLoops(int source, const std::vector<Keyframe>& keyframes,
                                   const PlaceIndex& index, const FindLoopsOptions& options);

}  // namespace surfit
