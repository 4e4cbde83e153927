#pragma once

#include <vector>

#include "finishing/stereo/matched_image.h"
#include "surfit/core/image.h"

namespace surfit {

// Steps of RefineLabels(): labels from -range to range around the label of a pixel.
struct RefinedSteps {
  float range = 0;
  int count = 0;
};

// Improves labels with the brightness of subpixels, relative to its local mean. The costs of equal
// steps from the labels of neighbouring pixels are summed over 7 x 7 pixels, so the window follows
// slanted surfaces. Neighbours at depth edges are ignored. The labels are smoothed first. A pixel
// without texture keeps its smoothed label. `labels`: -1: none; these pixels stay. `refined`: not 0
// for the pixels that change. Single-threaded.
Image<float> RefineLabels(const Image<float>& labels, const Image<std::uint8_t>& refined,
                          const LabelRange& range, const MatchedImage& image,
                          const std::vector<const MatchedImage*>& neighbours,
                          const RefinedSteps& steps);

}  // namespace surfit
