#pragma once

#include <vector>

#include "surfit/geometry/sensor.h"
#include "surfit/optimization/keyframes.h"

namespace surfit {

// Colour latency: additional time from capture to timestamp of colour, relative to depth.
struct ColorLatency {
  double latency_s = 0;
  double sigma_s = 0;  // standard deviation; that of the prior without an estimate
  int keyframes = 0;   // keyframes used for the estimate
};

// Keyframe with the time from its pose to its colour image, by their timestamps.
struct ColoredKeyframe {
  const RefinementKeyframe& keyframe;
  double color_after_s = 0;
};

// Estimates the colour latency from keyframes of one camera. `prior_sigma_s` is the standard
// deviation of a latency of 0. A surface point has the same colour in two keyframes, except for
// exposure. The point has the coordinates X in the first camera, with image I, and Y in the second
// camera, with image J. The cameras move as in KeyframeReadout:
//   I(pi(X - t m(X))) = gain J(pi(Y - s n(Y))) + offset,
//   t = color_after_s - latency of the first keyframe, s of the second keyframe,
//   m(X) = turn x X + velocity of the first camera, n(Y) of the second camera.
// Gauss-Newton over the latency, with a robust kernel (Geman-McClure). Gain and offset of each pair
// of keyframes are eliminated. The variance is that of the sum of the gradients of the keyframes,
// from their scatter (Huber 1967), combined with the prior.
//
// The latency is 0 if it is not significant at three standard deviations. It is also 0, with 0
// keyframes, if fewer than 10 keyframes can be compared, if it does not converge, or if it exceeds
// 0.1 s.
ColorLatency EstimateColorLatency(const std::vector<ColoredKeyframe>& keyframes,
                                  const PinholeCamera& camera, double prior_sigma_s);

}  // namespace surfit
