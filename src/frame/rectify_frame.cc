#include "surfit/frame/rectify_frame.h"

#include <cmath>
#include <utility>

#include "frame/lens.h"
#include "frame/register_color.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"
#include "surfit/core/parallel.h"

namespace surfit {
namespace {

void RequireUsable(const PinholeCamera& camera, const std::string& what) {
  ThrowIf(camera.fy < 0, what, ": fy is ", camera.fy, ", must be positive: mirror the camera");
  ThrowIf(camera.width < 2 || camera.height < 2, what, " is ", camera.width, " x ", camera.height,
          " pixels, must have at least 2 x 2");
}

template <typename T>
void RequireSize(const Image<T>& image, const PinholeCamera& camera, const char* what) {
  ThrowIf(image.width() != camera.width || image.height() != camera.height, "the ", what,
          " image has ", image.width(), " x ", image.height(), " pixels, must have ", camera.width,
          " x ", camera.height, " like its camera");
}

constexpr std::uint16_t kMissing = 65535;

float Metres(std::uint16_t raw, float units_per_metre, float max_m) {
  const float metres = raw / units_per_metre;
  return raw != kMissing && metres <= max_m ? metres : 0;
}

// Returns 0 for NaN, because comparisons with NaN are false.
float Metres(float raw, float /*units_per_metre*/, float max_m) {
  return raw > 0 && raw <= max_m ? raw : 0;
}

bool IsMissing(std::uint16_t raw) { return raw == 0 || raw == kMissing; }
bool IsMissing(float raw) { return !(raw > 0); }  // true for NaN as well

template <typename T>
float MetresOf(const Disparity& disparity, T raw, float max_m) {
  const double inverse = disparity.InverseDepth(raw);
  if (IsMissing(raw) || !(inverse > 0)) return 0;
  const auto metres = static_cast<float>(1 / inverse);
  return metres <= max_m ? metres : 0;
}

// For each undistorted, downsampled pixel: index of the nearest raw pixel; -1: outside the raw
// image.
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

// Depth in m per output pixel; 0: missing or larger than `max_depth_m`. `pixels`: result of
// NearestPixels().
Image<float> DepthAt(const Image<std::int32_t>& pixels, const RawDepth& raw,
                     const RgbdCamera& camera, double max_depth_m) {
  const float units = static_cast<float>(camera.depth_units_per_metre);
  const float max_m = static_cast<float>(max_depth_m);
  Image<float> depth_m(pixels.width(), pixels.height());
  std::visit(
      [&](const auto& image) {
        const auto set_all = [&](const auto& metres) {
          for (std::size_t i = 0; i < pixels.size(); ++i)
            depth_m[i] = pixels[i] < 0 ? 0 : metres(image[pixels[i]]);
        };
        if (camera.disparity.IsGiven()) {
          set_all([&](auto value) { return MetresOf(camera.disparity, value, max_m); });
        } else {
          set_all([&](auto value) { return Metres(value, units, max_m); });
        }
      },
      raw);
  return depth_m;
}

}  // namespace

struct FrameRectifier::Tables {
  Tables(const RgbdCamera& source, const RectifyOptions& options)
      : camera(source),
        pinhole(source.depth.Subsampled(options.downsample)),
        max_depth_m(options.max_depth_m),
        depth_pixels(NearestPixels(source.depth, options.downsample)),
        color_registration(source, options.downsample) {
    pinhole.distortion = {};
  }

  RgbdCamera camera;
  PinholeCamera pinhole;
  double max_depth_m;
  Image<std::int32_t> depth_pixels;
  ColorRegistration color_registration;
};

FrameRectifier::FrameRectifier(const RgbdCamera& camera, const RectifyOptions& options) {
  Validate(options);
  camera.Validate("camera");
  RequireUsable(camera.depth, "depth camera");
  if (!camera.color_is_registered) RequireUsable(camera.color, "color camera");
  tables_ = std::make_unique<Tables>(camera, options);
}

FrameRectifier::FrameRectifier(FrameRectifier&&) noexcept = default;
FrameRectifier::~FrameRectifier() = default;

const PinholeCamera& FrameRectifier::pinhole() const { return tables_->pinhole; }

RgbdFrame FrameRectifier::Rectify(const RawDepth& depth, Image<Rgb8> color) const {
  const Tables& t = *tables_;
  std::visit([&](const auto& image) { RequireSize(image, t.camera.depth, "depth"); }, depth);
  RgbdFrame frame;
  frame.depth_m = DepthAt(t.depth_pixels, depth, t.camera, t.max_depth_m);
  if (!color.empty()) {
    RequireSize(color, t.camera.color_is_registered ? t.camera.depth : t.camera.color, "colour");
    frame.color = t.color_registration.Apply(std::move(color), frame.depth_m);
  }
  return frame;
}

void CorrectDepth(const PinholeCamera& camera, const InverseDepthField& field,
                  Image<float>* depth_m) {
  const auto& c = field.coefficients;
  const auto correct_row = [&, depth_m](int v) {
    const double y = (v - camera.cy) / camera.fy;
    const double at_0 = c[0] + (c[2] + c[5] * y) * y, slope = c[1] + c[4] * y;
    float* const row = &(*depth_m)(0, v);
    for (int u = 0; u < depth_m->width(); ++u) {
      const double x = (u - camera.cx) / camera.fx, z = row[u];
      const double share = 1 + z * (at_0 + (slope + c[3] * x) * x);
      row[u] = share > InverseDepthField::kMinInverse * z ? static_cast<float>(z / share) : 0.f;
    }
  };
  ParallelFor(0, depth_m->height(), kRowsPerBlock, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) correct_row(v);
  });
}

}  // namespace surfit
