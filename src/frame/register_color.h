#pragma once

#include <algorithm>
#include <cstdint>

#include "surfit/core/image.h"
#include "surfit/geometry/sensor.h"

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

// Gives the pixels of the undistorted, downsampled depth image their colours. The point that a
// depth pixel sees, x = d ray, appears to the colour camera at color_from_depth * x = d R ray + t.
// Where that pixel does not depend on d (t = 0, or colour is registered to depth) it is looked up
// in a table; else pixels without depth have no colour. The colour camera is assumed to see what
// the depth camera sees: along occlusion edges, as wide as the parallax, it may see the foreground.
class ColorRegistration {
 public:
  ColorRegistration(const RgbdCamera& camera, int downsample);

  // color has the colour camera's size; depth_m the output's.
  Image<Rgb8> Apply(Image<Rgb8> color, const Image<float>& depth_m) const;

 private:
  // The taps of the points at these depths (m; 0 = none) on the rays of output row v.
  void FindTaps(int v, const float* depth_m, BilinearTap* taps) const;

  PinholeCamera pinhole_;  // of the output
  PinholeCamera color_;
  Eigen::Matrix3d rotation_;     // of color_from_depth
  Eigen::Vector3d translation_;  // m
  bool is_copy_;                 // each output pixel is the colour pixel at the same place
  Image<BilinearTap> taps_;      // empty where the tap depends on depth
};

}  // namespace surfit
