#pragma once

#include <vector>

#include "surfit/places/verify_loop.h"

namespace surfit {

// Where the registration of one view to another may start.
struct LoopStarts {
  std::vector<Rigid3d> target_from_source;  // those that most features agree on first
  int matches = 0;                          // features alike in both views
  int agreeing_features = 0;                // the most that agree on one pose
};

// Poses that enough of the views' features agree on.
LoopStarts FindLoopStarts(const PlaceView& source, const PlaceView& target,
                          const VerifyLoopOptions& options);

}  // namespace surfit
