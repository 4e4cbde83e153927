#pragma once

#include <vector>

#include "registration/feature_points.h"
#include "surfit/places/keyframe.h"

namespace surfit {

// Features whose descriptors are each other's nearest, near enough, and nearer than the second
// nearest by a clear ratio.
std::vector<FeatureMatch> MatchFeatures(const std::vector<PlaceFeature>& source,
                                        const std::vector<PlaceFeature>& target);

}  // namespace surfit
