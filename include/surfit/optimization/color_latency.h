#pragma once

#include <vector>

#include "surfit/geometry/sensor.h"
#include "surfit/optimization/keyframes.h"

namespace surfit {

// By how much longer than depth colour has taken from its moment to its stamp.
struct ColorLatency {
  double latency_s = 0;
  double sigma_s = 0;  // its standard deviation; that of the prior where nothing was seen
  int keyframes = 0;   // that told of it
};

// A keyframe, and when its colours were taken after the moment of its pose, by their stamps.
struct ColoredKeyframe {
  const RefinementKeyframe& keyframe;
  double color_after_s = 0;
};

// Of keyframes that have intensities, by one camera. A surface point that two keyframes see has the
// same colour in both, but for exposure: with its places X in one camera and Y in the other, both
// moving as KeyframeReadout tells, and images I, J,
//   I(pi(X - t m(X))) = gain J(pi(Y - s n(Y))) + offset,
//   t = color_after_s - latency, s likewise,
// with m(X) = turn x X + velocity. Gauss-Newton over the latency, with a gain and an offset for
// each pair of keyframes eliminated and a robust kernel (Geman-McClure). Its variance is that of
// the sum of the keyframes' gradients, as these scatter (Huber 1967), joined with the prior's. 0
// where that is not more than three standard deviations: what is not known stays as it is.
ColorLatency EstimateColorLatency(const std::vector<ColoredKeyframe>& keyframes,
                                  const PinholeCamera& camera, double prior_sigma_s);

}  // namespace surfit
