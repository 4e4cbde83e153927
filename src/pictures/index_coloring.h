#pragma once

#include <cstdint>
#include <functional>

#include "surfit/core/image.h"

namespace surfit {

// The image that the function gives for each pixel and its index, computed in parallel.
Image<Rgb8> ColorIndices(const Image<std::int32_t>& indices,
                         const std::function<Rgb8(int u, int v, std::int32_t index)>& color_of);

// The colour at this share of its brightness, 0 <= brightness <= 1.
Rgb8 Dimmed(Rgb8 color, float brightness);

}  // namespace surfit
