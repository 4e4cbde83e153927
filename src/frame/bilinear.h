#pragma once

#include <algorithm>
#include <cstdint>

#include "surfit/core/image.h"

namespace surfit {

// Where to look up a colour between four pixels.
struct BilinearTap {
  std::int32_t index = -1;     // of the upper left pixel; -1 = outside the image
  std::uint16_t weight_u = 0;  // of the right pixels, in 1/256
  std::uint16_t weight_v = 0;  // of the lower pixels, in 1/256
};

// The tap at a pixel position of an image at least 2 x 2 in size; positions beyond the outermost
// pixel centres take these.
inline BilinearTap TapAt(float pixel_u, float pixel_v, int width, int height) {
  const float u = std::clamp(pixel_u, 0.f, width - 1.f);
  const float v = std::clamp(pixel_v, 0.f, height - 1.f);
  const int left = std::min(static_cast<int>(u), width - 2);
  const int top = std::min(static_cast<int>(v), height - 2);
  return {top * width + left, static_cast<std::uint16_t>((u - left) * 256 + 0.5f),
          static_cast<std::uint16_t>((v - top) * 256 + 0.5f)};
}

// The colour at a tap; (0, 0, 0) outside.
inline Rgb8 SampleBilinear(const Image<Rgb8>& image, const BilinearTap& tap) {
  if (tap.index < 0) return {};
  const Rgb8* const upper = image.data() + tap.index;
  const Rgb8* const lower = upper + image.width();
  const auto mix = [&](std::uint8_t Rgb8::*channel) {
    const unsigned wu = tap.weight_u, wv = tap.weight_v;
    const unsigned above = upper[0].*channel * (256 - wu) + upper[1].*channel * wu;
    const unsigned below = lower[0].*channel * (256 - wu) + lower[1].*channel * wu;
    return static_cast<std::uint8_t>((above * (256 - wv) + below * wv + (1u << 15)) >> 16);
  };
  return {mix(&Rgb8::r), mix(&Rgb8::g), mix(&Rgb8::b)};
}

}  // namespace surfit
