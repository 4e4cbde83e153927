#pragma once

#include <vector>

#include "surfit/geometry/sensor.h"
#include "surfit/optimization/keyframes.h"

namespace surfit {

// Colour latency: (timestamp - capture time) of colour minus (timestamp - capture time) of
// depth.
struct ColorLatency {
  double latency_s = 0;
  double sigma_s = 0;  // standard deviation; without an estimate: of the prior
  int keyframes = 0;   // keyframes that were compared with earlier keyframes
};

// Keyframe with colour. Does not own the keyframe, which must outlive this object.
struct ColoredKeyframe {
  const RefinementKeyframe& keyframe;
  double color_after_s = 0;  // RgbdFrame::color_stamp_s minus time of the pose
};

// Estimates the colour latency from keyframes of one camera, in the order of time. `camera` must
// have the size of the keyframe images, which is not checked. The prior has the mean 0 and the
// standard deviation `prior_sigma_s`. A `prior_sigma_s` of 0 gives the latency 0, unlike in
// CalibrationPrior. Runs on the calling thread.
//
// Minimises the difference of colour between keyframe pairs. A surface point has the coordinates X
// in the first camera (image I) and Y in the second camera (image J). The cameras move as in
// KeyframeReadout:
//   I(pi(X - t m(X))) = gain J(pi(Y - s n(Y))) + offset,
//   t = color_after_s - latency of the first keyframe, s of the second keyframe,
//   m(X) = turn x X + velocity of the first camera, n(Y) of the second camera.
// The solver is Gauss-Newton over the latency with a Geman-McClure kernel. Gain and offset of each
// pair are eliminated. The variance follows from the scatter of the gradients (Huber 1967) and the
// prior.
//
// Results below three standard deviations are set to 0. Without an estimate, `latency_s` and
// `keyframes` are 0. Reasons: fewer than 10 comparable keyframes, no convergence, or a latency
// above 0.1 s.
ColorLatency EstimateColorLatency(const std::vector<ColoredKeyframe>& keyframes,
                                  const PinholeCamera& camera, double prior_sigma_s);

}  // namespace surfit
