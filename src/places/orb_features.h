#pragma once

#include <vector>

#include "registration/feature_points.h"
#include "surfit/core/image.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/places/keyframe.h"

namespace surfit {

// ORB features (Rublee et al. 2011) of the image, the strongest of each cell of a grid, lifted by
// the depth of the surface that it shares pixels with. Features without depth are left out. At most
// `max_count`; none where there is no colour.
std::vector<PlaceFeature> FindOrbFeatures(const Image<Rgb8>& color, const FrameLevel& surface,
                                          int max_count);

// Features whose descriptors are each other's nearest, near enough, and nearer than the second
// nearest by a clear ratio.
std::vector<FeatureMatch> MatchFeatures(const std::vector<PlaceFeature>& source,
                                        const std::vector<PlaceFeature>& target);

}  // namespace surfit
