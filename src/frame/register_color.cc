#include "frame/register_color.h"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "frame/lens.h"
#include "surfit/core/lanes.h"

namespace surfit {
namespace {

constexpr float kColumns[] = {0, 1, 2, 3, 4, 5, 6, 7};
constexpr double kOutside = -1;

// Colour image coordinates for a row of depth pixels, in 1/256 px. u is kOutside if the colour
// camera does not see the point.
struct TapPositions {
  explicit TapPositions(int width)
      : u(width + Lanes<float>::kCount), v(width + Lanes<float>::kCount) {}
  std::vector<std::int32_t> u, v;
};

// Points of a row of depth pixels in the frame of the colour camera. A pixel in column u with depth
// d has the point d (first + u step) + t.
struct PointRow {
  Eigen::Vector3f first, step, t;
};

template <typename V>
void ProjectRow(const PointRow& points, const float* depth_m, int width,
                const PinholeCamera& camera, TapPositions* positions) {
  const Lens<V> lens(camera);
  for (int u = 0; u < width; u += V::kCount) {
    const V d = V::LoadUpTo(depth_m + u, width - u), column = V::Load(kColumns) + u;
    const auto coordinate = [&](int i) {
      return d * (points.first[i] + column * points.step[i]) + points.t[i];
    };
    const LensPixel<V> pixel = lens.Project(coordinate(0), coordinate(1), coordinate(2));
    const auto is_in_image = IsInImage(camera, pixel) & (d > 0.);
    Select(is_in_image, TapSteps(pixel.u, camera.width), kOutside)
        .StoreTruncated(positions->u.data() + u);
    Select(is_in_image, TapSteps(pixel.v, camera.height), kOutside)
        .StoreTruncated(positions->v.data() + u);
  }
}

using EightWords __attribute__((vector_size(32))) = std::uint32_t;

// Samples eight pixels inside of the colour image. Bitwise identical to SampleBilinear().
void SampleEight(const Image<Rgb8>& image, const BilinearTap* taps, Rgb8* out) {
  static_assert(sizeof(Rgb8) == 3);
  const auto* const first = reinterpret_cast<const char*>(image.data());
  const std::ptrdiff_t stride = 3 * static_cast<std::ptrdiff_t>(image.width());
  std::uint32_t words[5][8];
  for (int k = 0; k < 8; ++k) {
    // Two neighbour pixels have six bytes: bytes 0 to 3 have the left one, bytes 2 to 5 the right.
    const char* const upper = first + 3 * static_cast<std::ptrdiff_t>(taps[k].index);
    std::memcpy(&words[0][k], upper, 4);
    std::memcpy(&words[1][k], upper + 2, 4);
    std::memcpy(&words[2][k], upper + stride, 4);
    std::memcpy(&words[3][k], upper + stride + 2, 4);
    words[4][k] = taps[k].weight_u | std::uint32_t{taps[k].weight_v} << 16;
  }
  EightWords corners[4], weights;  // corners: upper left, upper right, lower left, lower right
  std::memcpy(&corners, &words, sizeof(corners));
  std::memcpy(&weights, &words[4], sizeof(weights));
  corners[1] >>= 8;
  corners[3] >>= 8;
  const EightWords weight_u = weights & 0xffffu, weight_v = weights >> 16;
  EightWords rgb = {};
  for (int i = 0; i < 3; ++i) {
    const EightWords a = corners[0] >> (8 * i) & 255u, b = corners[1] >> (8 * i) & 255u;
    const EightWords c = corners[2] >> (8 * i) & 255u, d = corners[3] >> (8 * i) & 255u;
    const EightWords upper = 256u * a + weight_u * (b - a), lower = 256u * c + weight_u * (d - c);
    rgb |= ((256u * upper + weight_v * (lower - upper) + (1u << 15)) >> 16) << (8 * i);
  }
  // Each pixel but the last one also writes the first byte of the next pixel.
  for (int k = 0; k < 8; ++k) {
    const std::uint32_t word = rgb[k];
    std::memcpy(&out[k].r, &word, k < 7 ? 4 : 3);
  }
}

void SampleRow(const Image<Rgb8>& image, const BilinearTap* taps, int count, Rgb8* out) {
  const int eights = count / 8 * 8;
  WithInstructions([&](auto) {
    for (int u = 0; u < eights; u += 8) {
      int inside = 0;
      for (int k = 0; k < 8; ++k) inside += taps[u + k].index >= 0;
      if (inside == 8) {
        SampleEight(image, taps + u, out + u);
      } else {
        for (int k = 0; k < 8; ++k) out[u + k] = SampleBilinear(image, taps[u + k]);
      }
    }
  });
  for (int u = eights; u < count; ++u) out[u] = SampleBilinear(image, taps[u]);
}

}  // namespace

ColorRegistration::ColorRegistration(const RgbdCamera& camera, int downsample)
    : pinhole_(camera.depth.Subsampled(downsample)),
      color_(camera.color_is_registered ? camera.depth : camera.color),
      is_copy_(camera.color_is_registered && !color_.HasDistortion() && downsample == 1) {
  const Rigid3d transform = camera.color_is_registered ? Rigid3d() : camera.color_from_depth;
  rotation_ = transform.rotation.toRotationMatrix();
  translation_ = transform.translation;
  if (is_copy_ || !translation_.isZero(0)) return;
  taps_ = Image<BilinearTap>(pinhole_.width, pinhole_.height);
  const std::vector<float> any_depth_m(pinhole_.width, 1.f);
  for (int v = 0; v < pinhole_.height; ++v) FindTaps(v, any_depth_m.data(), taps_.row(v));
}

void ColorRegistration::FindTaps(int v, const float* depth_m, BilinearTap* taps) const {
  const PointRow points = {(rotation_ * pinhole_.Ray(0, v)).cast<float>(),
                           (rotation_.col(0) / pinhole_.fx).cast<float>(),
                           translation_.cast<float>()};
  TapPositions positions(pinhole_.width);
  WithInstructions([&](auto instructions) {
    using V = Lanes<float, decltype(instructions)>;
    ProjectRow<V>(points, depth_m, pinhole_.width, color_, &positions);
  });
  const std::int32_t *steps_u = positions.u.data(), *steps_v = positions.v.data();
  const int width = color_.width, height = color_.height, count = pinhole_.width;
  WithInstructions([&](auto) {
    for (int u = 0; u < count; ++u) {
      // Steps are at least 0 inside the image, and -1 outside.
      const BilinearTap tap = TapAt(steps_u[u], steps_v[u], width, height);
      taps[u] = {steps_u[u] < 0 ? -1 : tap.index, tap.weight_u, tap.weight_v};
    }
  });
}

Image<Rgb8> ColorRegistration::Apply(Image<Rgb8> color, const Image<float>& depth_m) const {
  if (is_copy_) return color;
  Image<Rgb8> registered(pinhole_.width, pinhole_.height);
  std::vector<BilinearTap> found(pinhole_.width);
  for (int v = 0; v < pinhole_.height; ++v) {
    if (taps_.empty()) FindTaps(v, depth_m.row(v), found.data());
    const BilinearTap* const taps = taps_.empty() ? found.data() : taps_.row(v);
    SampleRow(color, taps, pinhole_.width, registered.row(v));
  }
  return registered;
}

}  // namespace surfit
