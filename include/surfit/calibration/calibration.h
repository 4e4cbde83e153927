#pragma once

#include <cstddef>

#include "surfit/optimization/color_latency.h"
#include "surfit/optimization/refine.h"

namespace surfit {

class OptionVisitor;

// Calibration of the depth camera during tracking: options and results. Read
// src/calibration/calibrator.h next.

// Refinement options with few surfels and rounds, because calibration repeats during tracking.
inline RefinementOptions CoarseRefinementOptions() {
  RefinementOptions options;
  options.cells_across = 40;
  options.max_rounds = 3;
  options.kernel_growth = 2;
  return options;
}

// Options of calibration during tracking. Refine() runs on all keyframes so far. The first run
// needs `first_keyframes` keyframes. Each further run needs 25 % more keyframes, at least one more.
// The result of n keyframes is applied 1 + n/2 + n^2/40 frames (both rounded down) after the run
// starts, on every machine. In real time, it may be applied later. The input calibration is kept
// unless the estimate differs significantly. LoopOptions::keyframes selects the keyframes, also
// without loop closure. A run uses every second column and row of the images; px in `refinement`
// refer to these images. RefinementOptions::prior is completed by the prior of the sensor.
struct CalibrationOptions {
  bool enabled = true;
  int first_keyframes = 4;
  int max_keyframes = 45;  // no further run if it would need more keyframes
  RefinementOptions refinement = CoarseRefinementOptions();

  void Visit(OptionVisitor& visitor);
};

// Record of one calibration run during tracking. Before the result is applied, `frame` is 0 and
// `summary` and `color_latency` have their default values.
struct CalibrationRecord {
  std::size_t keyframes = 0;
  int begun_frame = 0;  // index of the last of these keyframes
  int frame = 0;        // index of the last frame with a pose before the result was applied
  RefinementSummary summary;
  ColorLatency color_latency;  // in addition to RgbdCamera::color_latency_s
};

}  // namespace surfit
