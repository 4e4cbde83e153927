#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <optional>

#include "finishing/known_sequence.h"
#include "surfit/optimization/refine.h"

namespace surfit {

// A run's poses and calibration, refined.
struct RefinedSequence {
  std::size_t keyframes = 0;
  RefinementSummary summary;  // of the frames as they were read
  // As they were where refinement failed.
  Trajectory trajectory;
  FoundSensor found;
};

// Refines keyframes of the poses that are known in the end, and the calibration from what was
// found, as Refine() does: by few surfels of images of about 320 columns, so that it takes no
// longer than tracking did. `camera` is that of the frames as they were read. The other poses move
// along. `progress` is called after each round. Nothing if it is interrupted. Throws InputError if
// the sequence cannot be read.
std::optional<RefinedSequence> RefineKnown(
    const KnownSequence& known, const PinholeCamera& camera, const std::atomic<bool>& interrupted,
    const std::function<void(const RefinementRound&)>& progress);

}  // namespace surfit
