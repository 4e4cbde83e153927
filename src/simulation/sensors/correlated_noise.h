#pragma once

#include <cstdint>

#include "surfit/core/image.h"

namespace surfit {

// Image of standard normal values with the correlation exp(-(r / correlation_px)^2) at a distance
// of r px. correlation_px = 0: independent pixels. The same seed gives the same image for any
// number of threads.
Image<float> CorrelatedNoise(int width, int height, double correlation_px, std::uint64_t seed);

// Share of the standard normal distribution below a value: uniform from 0 to 1 for such an image.
double NormalRatio(double value);

}  // namespace surfit
