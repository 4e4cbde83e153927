#pragma once

#include <algorithm>

#include "surfit/core/image.h"

namespace surfit {

// A value between four pixels, and how it changes per pixel.
struct BilinearSample {
  float value = 0;
  float slope_u = 0;
  float slope_v = 0;
};

// At a place within half a pixel of the image, which is at least 2 x 2; beyond the outermost pixel
// centres it goes on linearly.
inline BilinearSample SampleAt(const Image<float> &image, float u, float v) {
  const int left = std::clamp(static_cast<int>(u), 0, image.width() - 2);
  const int top = std::clamp(static_cast<int>(v), 0, image.height() - 2);
  const float a = u - static_cast<float>(left), b = v - static_cast<float>(top);
  const float *const upper = image.row(top) + left, *const lower = image.row(top + 1) + left;
  const float on_top = upper[0] + a * (upper[1] - upper[0]);
  const float below = lower[0] + a * (lower[1] - lower[0]);
  return {on_top + b * (below - on_top),
          (1 - b) * (upper[1] - upper[0]) + b * (lower[1] - lower[0]), below - on_top};
}

}  // namespace surfit
