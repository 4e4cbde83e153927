#include "frame/undistort_depth.h"

#include <cmath>

#include "frame/lens.h"

namespace surfit {
namespace {

constexpr std::uint16_t kMissing = 65535;

float Metres(std::uint16_t raw, float units_per_metre, float max_m) {
  const float metres = raw / units_per_metre;
  return raw != kMissing && metres <= max_m ? metres : 0;
}

// False comparisons make NaN missing.
float Metres(float raw, float /*units_per_metre*/, float max_m) {
  return raw > 0 && raw <= max_m ? raw : 0;
}

}  // namespace

Image<std::int32_t> NearestPixels(const PinholeCamera& camera, int downsample) {
  const PinholeCamera out = camera.Subsampled(downsample);
  const Lens<double> lens(camera);
  Image<std::int32_t> pixels(out.width, out.height, -1);
  for (int v = 0; v < out.height; ++v) {
    for (int u = 0; u < out.width; ++u) {
      const LensPixel<double> pixel = lens.Project(out.Ray(u, v));
      if (!IsInImage(camera, pixel)) continue;
      pixels(u, v) = static_cast<std::int32_t>(std::floor(pixel.v + 0.5)) * camera.width +
                     static_cast<std::int32_t>(std::floor(pixel.u + 0.5));
    }
  }
  return pixels;
}

Image<float> DepthAt(const Image<std::int32_t>& pixels, const RawDepth& raw,
                     double depth_units_per_metre, double max_depth_m) {
  const float units = static_cast<float>(depth_units_per_metre);
  const float max_m = static_cast<float>(max_depth_m);
  Image<float> depth_m(pixels.width(), pixels.height());
  std::visit(
      [&](const auto& image) {
        for (std::size_t i = 0; i < pixels.size(); ++i) {
          depth_m[i] = pixels[i] < 0 ? 0 : Metres(image[pixels[i]], units, max_m);
        }
      },
      raw);
  return depth_m;
}

}  // namespace surfit
