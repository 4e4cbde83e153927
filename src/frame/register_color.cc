#include "frame/register_color.h"

#include "frame/lens.h"

namespace surfit {

ColorRegistration::ColorRegistration(const RgbdCamera& camera, int downsample)
    : pinhole_(camera.depth.Subsampled(downsample)),
      color_(camera.color_is_registered ? camera.depth : camera.color),
      color_from_depth_(camera.color_is_registered ? Rigid3d() : camera.color_from_depth),
      is_copy_(camera.color_is_registered && !color_.HasDistortion() && downsample == 1) {
  if (is_copy_ || !color_from_depth_.translation.isZero(0)) return;
  taps_ = Image<BilinearTap>(pinhole_.width, pinhole_.height);
  for (int v = 0; v < pinhole_.height; ++v) {
    for (int u = 0; u < pinhole_.width; ++u) taps_(u, v) = TapOf(pinhole_.Ray(u, v));
  }
}

BilinearTap ColorRegistration::TapOf(const Eigen::Vector3d& point_in_depth_camera) const {
  const auto pixel = ProjectThroughLens(color_, color_from_depth_ * point_in_depth_camera);
  if (!pixel || !IsInImage(color_, *pixel)) return {};
  return TapAt(*pixel, color_.width, color_.height);
}

Image<Rgb8> ColorRegistration::Apply(Image<Rgb8> color, const Image<float>& depth_m) const {
  if (is_copy_) return color;
  Image<Rgb8> registered(pinhole_.width, pinhole_.height);
  if (!taps_.empty()) {
    for (std::size_t i = 0; i < taps_.size(); ++i) registered[i] = SampleBilinear(color, taps_[i]);
    return registered;
  }
  for (int v = 0; v < pinhole_.height; ++v) {
    for (int u = 0; u < pinhole_.width; ++u) {
      const float depth = depth_m(u, v);
      if (depth > 0) registered(u, v) = SampleBilinear(color, TapOf(depth * pinhole_.Ray(u, v)));
    }
  }
  return registered;
}

}  // namespace surfit
