#pragma once

#include <Eigen/Core>
#include <vector>

namespace surfit {

// Covariance of the third differences of the prior with the difference of both trajectories, and
// its standard deviation. The true motion does not contribute.
struct PriorPart {
  double variance = 0, sigma = 0;
};

// Statistics of two trajectories of one camera, of rotations or translations. Variances are per
// component: rad^2 or m^2.
struct NoiseStatistics {
  // Mean squared difference of both motions over 1, 2, 4, ... frames, and the number of independent
  // windows of each. At least one of each.
  std::vector<double> spread, windows;
  double prior_third = 0;  // variance of the third differences of the prior, with the true motion
  PriorPart part, part_of_two;  // of motions over one and over two frames
  double model_age_frames = 0;  // mean age of the surfels that frames are registered to; 0: unknown
  double smallest = 0;          // smallest variance
};

// Variances per frame and component of the errors of two trajectories.
//
// The prior has random-walk drift w and white noise v. Its spread over n frames is n w + 2 v. A
// registered pose has an error relative to the map, with the variance b. The error is correlated
// over some frames. The map adds drift: each surfel has the error of the frame that saw it first.
// So the spread grows up to the age of the visible surfels. The drift per frame is the spread at
// this age, divided by the age.
struct SourceNoise {
  std::vector<double> spread;  // as in NoiseStatistics
  double prior_drift = 0, prior_noise = 0;
  double registered_noise = 0;    // of consecutive frames
  double registered_bounded = 0;  // b
  double registered_drift = 0;
};

// The sum of both drifts follows from a fit of the spread. Third differences of motions over n
// frames of the prior have the variance 6 n w + 20 v, which separates the drifts. If they are too
// few, both drifts are equal. The spread over n frames bounds n w.
SourceNoise EstimateNoise(const NoiseStatistics& statistics);

// Third differences of both trajectories have equal size. Outliers do not contribute.
PriorPart MeasurePriorPart(const std::vector<Eigen::Vector3d>& prior,
                           const std::vector<Eigen::Vector3d>& registered);

// Variance per component from the lower quartile of squared norms of three components. 0 if empty.
double QuartileVariance(std::vector<double> squares);

}  // namespace surfit
