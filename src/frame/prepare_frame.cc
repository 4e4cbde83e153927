#include "surfit/frame/prepare_frame.h"

#include <glog/logging.h>

#include <cmath>
#include <utility>

#include "frame/register_color.h"
#include "frame/undistort_depth.h"
#include "surfit/core/error.h"
#include "surfit/core/options.h"

namespace surfit {
namespace {

void RequireUsable(const PinholeCamera& camera, const std::string& what) {
  if (camera.fy < 0)
    throw InputError(Concat(what, ": fy is ", camera.fy, ", must be positive: mirror the camera"));
  if (camera.width < 2 || camera.height < 2)
    throw InputError(Concat(what, " is ", camera.width, " x ", camera.height,
                            " pixels, must have at least 2 x 2"));
}

template <typename T>
bool HasSize(const Image<T>& image, const PinholeCamera& camera) {
  return image.width() == camera.width && image.height() == camera.height;
}

}  // namespace

struct FramePreparer::Tables {
  Tables(const RgbdCamera& source, const PrepareOptions& options)
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

FramePreparer::FramePreparer(const RgbdCamera& camera, const PrepareOptions& options) {
  Validate(options);
  camera.Validate("camera");
  RequireUsable(camera.depth, "depth camera");
  if (!camera.color_is_registered) RequireUsable(camera.color, "color camera");
  tables_ = std::make_unique<Tables>(camera, options);
}

FramePreparer::FramePreparer(FramePreparer&&) noexcept = default;
FramePreparer::~FramePreparer() = default;

const PinholeCamera& FramePreparer::pinhole() const { return tables_->pinhole; }

RgbdFrame FramePreparer::Prepare(const RawDepth& depth, Image<Rgb8> color) const {
  const Tables& t = *tables_;
  CHECK(std::visit([&](const auto& image) { return HasSize(image, t.camera.depth); }, depth));
  RgbdFrame frame;
  frame.depth_m = DepthAt(t.depth_pixels, depth, t.camera.depth_units_per_metre, t.max_depth_m);
  if (!color.empty()) {
    CHECK(HasSize(color, t.camera.color_is_registered ? t.camera.depth : t.camera.color));
    frame.color = t.color_registration.Apply(std::move(color), frame.depth_m);
  }
  return frame;
}

}  // namespace surfit
