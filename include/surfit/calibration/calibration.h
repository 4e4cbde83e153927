#pragma once

#include <cstddef>

#include "surfit/optimization/color_latency.h"
#include "surfit/optimization/refine.h"

namespace surfit {

class OptionVisitor;

// Calibration of the depth camera during tracking: options and results. Depends on refinement. Read
// src/calibration/calibrator.h next.

// Few surfels and rounds: a camera has few numbers, and is found again soon.
inline RefinementOptions CoarseRefinementOptions() {
  RefinementOptions options;
  options.cells_across = 40;
  options.max_rounds = 3;
  options.kernel_growth = 2;
  return options;
}

// How the depth camera is calibrated while it is tracked: by Refine() of all keyframes so far, when
// there are first_keyframes, and each time there are a quarter more. What n keyframes tell takes
// effect 1 + n/2 + n^2/40 frames later, however long it takes: the same on every machine. What is
// no other than the given calibration, as far as the covariance tells, changes nothing.
struct CalibrationOptions {
  bool enabled = true;
  int first_keyframes = 4;
  int max_keyframes = 45;  // beyond this the camera stays as it was found
  RefinementOptions refinement = CoarseRefinementOptions();

  void Visit(OptionVisitor& visitor);
};

// A calibration that was found while the camera was tracked.
struct CalibrationRecord {
  std::size_t keyframes = 0;
  int begun_frame = 0;  // the last of them
  int frame = 0;        // the last one before it took effect
  RefinementSummary summary;
  ColorLatency color_latency;  // beyond the given one
};

}  // namespace surfit
