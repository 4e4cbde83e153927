#include "frame/register_color.h"

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
  for (int u = 0; u < pinhole_.width; ++u) {
    taps[u] = positions.u[u] < 0
                  ? BilinearTap()
                  : TapAt(positions.u[u], positions.v[u], color_.width, color_.height);
  }
}

Image<Rgb8> ColorRegistration::Apply(Image<Rgb8> color, const Image<float>& depth_m) const {
  if (is_copy_) return color;
  Image<Rgb8> registered(pinhole_.width, pinhole_.height);
  std::vector<BilinearTap> found(pinhole_.width);
  for (int v = 0; v < pinhole_.height; ++v) {
    if (taps_.empty()) FindTaps(v, depth_m.row(v), found.data());
    const BilinearTap* const taps = taps_.empty() ? found.data() : taps_.row(v);
    Rgb8* const out = registered.row(v);
    for (int u = 0; u < pinhole_.width; ++u) out[u] = SampleBilinear(color, taps[u]);
  }
  return registered;
}

}  // namespace surfit
