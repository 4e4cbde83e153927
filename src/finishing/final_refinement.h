#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <optional>

#include "finishing/posed_sequence.h"
#include "surfit/optimization/refine.h"

namespace surfit {

struct RefinedSequence {
  std::size_t keyframes = 0;  // number of keyframes
  RefinementSummary summary;
  // See HeldOutGain(). 0 if the refinement failed, or if its calibration is insignificant or not
  // confirmed: see Refine().
  double held_out_gain = 0;
  // False if `held_out_gain` is below RefinementSummary::calibration_limit, or if only the refined
  // calibration contradicts the input sensor: see CalibrationWarning(). Without a better
  // calibration, the poses of tracking are more accurate than refined poses.
  bool is_applied = false;
  Trajectory trajectory;  // this and `found`: input values unless `is_applied`
  EstimatedSensor found;
};

// Refines keyframe poses and calibration with Refine(), and moves the other poses with their
// keyframes. Starts from the poses and calibration of the run. Uses images of at least 320 columns,
// if the frames have them, and few surfels. `camera` is the camera of the prepared frames of the
// run. `progress` must not be empty. It is called after each round. Returns std::nullopt if
// interrupted. Throws InputError if the sequence cannot be read. Uses at most 240 keyframes.
// `interrupted` is checked before each frame and after each round.
std::optional<RefinedSequence> RefinePosedSequence(
    const PosedSequence& known, const PinholeCamera& camera, const std::atomic<bool>& interrupted,
    const std::function<void(const RefinementRound&)>& progress);

}  // namespace surfit
