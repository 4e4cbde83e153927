#pragma once

#include "surfit/core/image.h"
#include "surfit/frame/frame_pyramid.h"

namespace surfit {

// Grey value of a colour from 0 (black) to 1 (white), with the weights of ITU-R BT.601.
inline float GreyOf(Rgb8 color) {
  return (0.299f * color.r + 0.587f * color.g + 0.114f * color.b) / 255.f;
}

// The mean of each block of 2 x 2 pixels; NaN where one of them is.
Image<float> HalfResolution(const Image<float>& fine);

// Gives all levels their intensities from the colours of the finest level's pixels, each level from
// the one before. (0, 0, 0) is no colour. Nothing is done where the colour image is empty.
void AddIntensity(const Image<Rgb8>& color, FramePyramid* pyramid);

}  // namespace surfit
