#pragma once

#include <vector>

#include "registration/feature_points.h"
#include "surfit/geometry/rigid3.h"

namespace surfit {

// A pose, and the matches that agree with it.
struct Consensus {
  Rigid3d target_from_source;
  std::vector<int> inliers;  // indices of the matches, ascending
};

// The pose that brings the matched source points to their target points by weighted least squares
// (Kabsch 1976; Umeyama 1991 without scale), weights from the points' sigmas. At least three of
// `used`, not on a line.
Rigid3d FitPose(const FeaturePoints& source, const FeaturePoints& target,
                const std::vector<FeatureMatch>& matches, const std::vector<int>& used);

// How many samples are drawn.
inline constexpr int kConsensusSamples = 20000;

// Random sample consensus (Fischler and Bolles 1981) with three matches a sample, drawn from a
// fixed seed: the poses that most matches agree with (four at least, within three sigmas), refined
// on these, the best first, at most `max_count`. Poses that share half of their inliers are one.
// At most `max_tries` samples whose sides are as long in both views are tried, of all that are
// drawn.
std::vector<Consensus> FindConsensus(const FeaturePoints& source, const FeaturePoints& target,
                                     const std::vector<FeatureMatch>& matches, int max_count,
                                     int max_tries = kConsensusSamples);

}  // namespace surfit
