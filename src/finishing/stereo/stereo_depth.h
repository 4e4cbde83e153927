#pragma once

#include <vector>

#include "finishing/stereo/matched_image.h"
#include "finishing/stereo/stereo_keyframe.h"
#include "surfit/core/image.h"

namespace surfit {

// Other keyframes that show the scene of a keyframe.
struct StereoNeighbours {
  std::vector<const MatchedImage*> matched;
  std::vector<const MatchedImage*> distant;  // with more parallax
};

// Matches the colours of a keyframe with its neighbours by a plane sweep. Only pixels without
// measured depth are matched; pixels around them keep their measured depth. The cost of a label is
// the mean of the least three costs of the neighbours, because other neighbours may not see the
// point. The cost of a neighbour is the number of different census bits plus the difference of
// brightness. BestLabels() gives the labels, and RefineLabels() their fractions, first by the
// matched and then by the distant neighbours. Returns the depth (m) of the unmeasured pixels; 0: no
// depth, or beyond the first or last label. Single-threaded.
Image<float> MatchDepth(const StereoKeyframe& keyframe, const LabelRange& labels,
                        const MatchedImage& image, const StereoNeighbours& neighbours);

}  // namespace surfit
