#pragma once

#include <cstddef>

#include "surfit/optimization/color_latency.h"
#include "surfit/optimization/refine.h"

namespace surfit {

class OptionVisitor;

// Calibration of the depth camera during tracking: options and results. Depends on refinement. Read
// src/calibration/calibrator.h next.

// Options of a fast refinement: few surfels and few rounds, because it is repeated during tracking.
inline RefinementOptions CoarseRefinementOptions() {
  RefinementOptions options;
  options.cells_across = 40;
  options.max_rounds = 3;
  options.kernel_growth = 2;
  return options;
}

// Options of calibration during tracking. Refine() runs on all keyframes so far: first with
// `first_keyframes` keyframes, then each time their number has grown by a quarter. An estimate from
// n keyframes is applied 1 + n/2 + n^2/40 frames after the task starts, so that the result does not
// depend on the machine. An estimate that does not differ significantly from the input calibration
// is discarded.
struct CalibrationOptions {
  bool enabled = true;
  int first_keyframes = 4;
  int max_keyframes = 45;  // keyframes; with more, the calibration does not change
  RefinementOptions refinement = CoarseRefinementOptions();

  void Visit(OptionVisitor& visitor);
};

// Record of one calibration during tracking.
struct CalibrationRecord {
  std::size_t keyframes = 0;
  int begun_frame = 0;  // index of the last of these keyframes
  int frame = 0;        // index of the last frame before the result was applied
  RefinementSummary summary;
  ColorLatency color_latency;  // in addition to RgbdCamera::color_latency_s
};

}  // namespace surfit
