#pragma once

#include <algorithm>
#include <cstdint>

#include "surfit/core/image.h"
#include "surfit/geometry/sensor.h"

namespace surfit {

// Position for SampleBilinear(): index of the upper left of four pixels (-1: outside the image),
// and weights of the right and the lower pixels in 1/256.
struct BilinearTap {
  std::int32_t index = -1;
  std::uint16_t weight_u = 0;
  std::uint16_t weight_v = 0;
};

// Pixel coordinate in 1/256 px, plus 0.5 for rounding by truncation. Clamped to the pixel centres
// of an image with `size` pixels.
template <typename V>
V TapSteps(const V& pixel, int size) {
  return Min(Max(pixel, 0.), size - 1.) * 256. + 0.5;
}

// Interpolation position from coordinates of TapSteps(). Requires at least 2 x 2 pixels.
inline BilinearTap TapAt(std::int32_t steps_u, std::int32_t steps_v, int width, int height) {
  const int left = std::min(steps_u >> 8, width - 2), top = std::min(steps_v >> 8, height - 2);
  return {top * width + left, static_cast<std::uint16_t>(steps_u - 256 * left),
          static_cast<std::uint16_t>(steps_v - 256 * top)};
}

// Interpolated colour; (0, 0, 0) outside the image. Red and blue share an integer: the weights sum
// to 2^16, so a sum has at most 24 bits.
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

// Registers colour to the undistorted, downsampled depth image. A depth pixel with the point x = d
// ray has the colour at color_from_depth * x = d R ray + t. `camera` has the parameters of both
// cameras. Colour images must have at least 2 x 2 pixels. Registered colour is undistorted and
// downsampled only. Apply() is thread-safe. Occlusion is ignored: background pixels near depth
// edges can get the colour of the foreground.
class ColorRegistration {
 public:
  ColorRegistration(const RgbdCamera& camera, int downsample);

  // `color` has the size of the colour camera, or of the depth camera if colour is registered.
  // `depth_m` (m; 0: missing) has the size of the output. Sizes are not checked. Pixels without
  // visible colour are (0, 0, 0). Pixels without depth are (0, 0, 0) if color_from_depth has a
  // translation.
  Image<Rgb8> Apply(Image<Rgb8> color, const Image<float>& depth_m) const;

 private:
  // Colour pixels of output row v for these depths (m; 0: missing).
  void FindTaps(int v, const float* depth_m, BilinearTap* taps) const;

  PinholeCamera pinhole_;  // of the output
  PinholeCamera color_;
  Eigen::Matrix3d rotation_;
  Eigen::Vector3d translation_;  // m
  bool is_copy_;
  Image<BilinearTap> taps_;  // empty if colour pixels depend on the depth
};

}  // namespace surfit
