#pragma once

#include <vector>

#include "surfit/core/image.h"

namespace surfit {

// How bright one pyramid level of a frame is.
struct BrightnessLevel {
  Image<float> value;   // 0 = black, 1 = white
  Image<float> detail;  // value less its mean over some pixels: edges and texture without shading
};

// With the detail of these values.
BrightnessLevel BrightnessOf(Image<float> value);

// As many levels as asked for, each further one the mean of 2 x 2 pixels like HalfResolution();
// all zero where there is no colour.
std::vector<BrightnessLevel> BrightnessPyramid(const Image<Rgb8>& color, int width, int height,
                                               int levels);

// The brightness `halvings` levels below that of the colours, without detail; empty without
// colours.
BrightnessLevel CoarseBrightness(const Image<Rgb8>& color, int halvings);

}  // namespace surfit
