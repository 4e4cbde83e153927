#include "simulation/sensors/exact_view.h"

#include <glog/logging.h>

#include <array>

namespace surfit {
namespace {

// IEC 61966-2-1: 8 bits to linear light from 0 to 1.
float LinearLight(std::uint8_t byte) {
  static const auto table = [] {
    std::array<float, 256> values;
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double s = static_cast<double>(i) / 255;
      values[i] = static_cast<float>(s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4));
    }
    return values;
  }();
  return table[byte];
}

// ITU-R BT.709.
float Luminance(Rgb8 color) {
  return 0.2126f * LinearLight(color.r) + 0.7152f * LinearLight(color.g) +
         0.0722f * LinearLight(color.b);
}

}  // namespace

ExactView::ExactView(const Rendering& exact, const PinholeCamera& camera)
    : exact_(exact), camera_(camera), reflectance_(camera.width, camera.height) {
  const auto fits = [&](const auto& image) {
    return image.width() == camera.width && image.height() == camera.height;
  };
  CHECK(fits(exact.depth_m) && fits(exact.color) && fits(exact.normal));
  std::transform(exact.color.begin(), exact.color.end(), reflectance_.begin(), Luminance);
}

bool ExactView::AreApart(int u, int v, int other_u, int other_v, double edge_ratio) const {
  const float here = Depth(u, v), there = Depth(other_u, other_v);
  if (!(here > 0 && there > 0)) return false;
  const Eigen::Vector3f difference = Point(other_u, other_v) - Point(u, v);
  const float distance = std::max(std::abs(Normal(u, v).dot(difference)),
                                  std::abs(Normal(other_u, other_v).dot(difference)));
  return distance > edge_ratio * std::min(here, there);
}

}  // namespace surfit
