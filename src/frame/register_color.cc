#include "frame/register_color.h"

namespace surfit {

ColorRegistration::ColorRegistration(const RgbdCamera& camera, int downsample)
    : pinhole_(camera.depth.Subsampled(downsample)),
      color_(camera.color_is_registered ? camera.depth : camera.color),
      color_lens_(color_),
      is_copy_(camera.color_is_registered && !color_.HasDistortion() && downsample == 1) {
  const Rigid3d transform = camera.color_is_registered ? Rigid3d() : camera.color_from_depth;
  rotation_ = transform.rotation.toRotationMatrix();
  translation_ = transform.translation;
  if (is_copy_ || !translation_.isZero(0)) return;
  taps_ = Image<BilinearTap>(pinhole_.width, pinhole_.height);
  const std::vector<float> any_depth_m(pinhole_.width, 1.f);
  PixelRow pixels(pinhole_.width);
  for (int v = 0; v < pinhole_.height; ++v) {
    ProjectRow(v, any_depth_m.data(), &pixels);
    for (int u = 0; u < pinhole_.width; ++u) taps_(u, v) = TapAtPixel(pixels[u]);
  }
}

void ColorRegistration::ProjectRow(int v, const float* depth_m, PixelRow* pixels) const {
  // R ray(u, v) is linear in u.
  const Eigen::Vector3f first = (rotation_ * pinhole_.Ray(0, v)).cast<float>();
  const Eigen::Vector3f step = (rotation_.col(0) / pinhole_.fx).cast<float>();
  const Eigen::Vector3f t = translation_.cast<float>();
  const Lens<float> lens = color_lens_;
  LensPixel<float>* const out = pixels->data();
  for (int u = 0; u < pinhole_.width; ++u) {
    const float d = depth_m[u], column = static_cast<float>(u);
    out[u] = lens.Project(d * (first.x() + column * step.x()) + t.x(),
                          d * (first.y() + column * step.y()) + t.y(),
                          d * (first.z() + column * step.z()) + t.z());
  }
}

BilinearTap ColorRegistration::TapAtPixel(const LensPixel<float>& pixel) const {
  if (!IsInImage(color_, pixel)) return {};
  return TapAt(pixel.u, pixel.v, color_.width, color_.height);
}

Image<Rgb8> ColorRegistration::Apply(Image<Rgb8> color, const Image<float>& depth_m) const {
  if (is_copy_) return color;
  Image<Rgb8> registered(pinhole_.width, pinhole_.height);
  if (!taps_.empty()) {
    for (std::size_t i = 0; i < taps_.size(); ++i) registered[i] = SampleBilinear(color, taps_[i]);
    return registered;
  }
  PixelRow pixels(pinhole_.width);
  for (int v = 0; v < pinhole_.height; ++v) {
    ProjectRow(v, depth_m.row(v), &pixels);
    for (int u = 0; u < pinhole_.width; ++u) {
      if (depth_m(u, v) > 0) registered(u, v) = SampleBilinear(color, TapAtPixel(pixels[u]));
    }
  }
  return registered;
}

}  // namespace surfit
