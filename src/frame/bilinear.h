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

// A pixel coordinate of an image `size` pixels wide or high in 1/256 px, to be truncated: positions
// beyond the outermost pixel centres take these.
template <typename V>
V TapSteps(const V& pixel, int size) {
  return Min(Max(pixel, 0.), size - 1.) * 256. + 0.5;
}

// The tap at such coordinates of an image at least 2 x 2 in size.
inline BilinearTap TapAt(std::int32_t steps_u, std::int32_t steps_v, int width, int height) {
  const int left = std::min(steps_u >> 8, width - 2), top = std::min(steps_v >> 8, height - 2);
  return {top * width + left, static_cast<std::uint16_t>(steps_u - 256 * left),
          static_cast<std::uint16_t>(steps_v - 256 * top)};
}

// The colour at a tap; (0, 0, 0) outside. Red and blue are summed in the halves of one number: the
// four weights sum to 2^16, so that no sum exceeds 24 bits.
inline Rgb8 SampleBilinear(const Image<Rgb8>& image, const BilinearTap& tap) {
  if (tap.index < 0) return {};
  const Rgb8* const upper = image.data() + tap.index;
  const Rgb8* const lower = upper + image.width();
  const std::uint32_t right = tap.weight_u * 256u, low = tap.weight_v * 256u;
  const std::uint32_t lower_right = std::uint32_t{tap.weight_u} * tap.weight_v;
  std::uint32_t green = 1u << 15;
  std::uint64_t red_blue = (std::uint64_t{1} << 15) | (std::uint64_t{1} << 47);
  const auto add = [&](const Rgb8& color, std::uint32_t weight) {
    green += color.g * weight;
    red_blue += (color.r | std::uint64_t{color.b} << 32) * weight;
  };
  add(upper[0], (1u << 16) - right - low + lower_right);
  add(upper[1], right - lower_right);
  add(lower[0], low - lower_right);
  add(lower[1], lower_right);
  return {static_cast<std::uint8_t>(red_blue >> 16), static_cast<std::uint8_t>(green >> 16),
          static_cast<std::uint8_t>(red_blue >> 48)};
}

}  // namespace surfit
