#pragma once

#include <cstdint>
#include <memory>
#include <variant>

#include "surfit/core/image.h"
#include "surfit/frame/rgbd_frame.h"
#include "surfit/geometry/inverse_depth_field.h"
#include "surfit/geometry/sensor.h"

namespace surfit {

class OptionVisitor;

// Raw depth image: depth along the optical axis, or disparity if RgbdCamera::disparity is given.
// - std::uint16_t: counts of 1/depth_units_per_metre or of the disparity; 0 and 65535 are missing.
// - float: metres or counts of the disparity; NaN, infinity, 0 and negative values are missing.
using RawDepth = std::variant<Image<std::uint16_t>, Image<float>>;

// Selection of pixels and depths.
struct RectifyOptions {
  int downsample = 1;      // keep every downsample-th column and row; 1 to 16
  double max_depth_m = 8;  // larger depths are treated as missing

  void Visit(OptionVisitor& visitor);
};

// Converts the images of an RGB-D camera to frames: removes distortion, registers colour to depth
// and downsamples. Tables are computed once. Rectify() is thread-safe. A moved-from object must not
// be used.
class FrameRectifier {
 public:
  // Throws InputError for invalid options or cameras, for fy < 0 (see Mirrored() in sensor.h), and
  // for images below 2 x 2 pixels.
  FrameRectifier(const RgbdCamera& camera, const RectifyOptions& options);
  FrameRectifier(FrameRectifier&&) noexcept;
  ~FrameRectifier();

  // Camera of the frames: undistorted depth camera, subsampled by `downsample`. Valid as long as
  // the object.
  const PinholeCamera& pinhole() const;

  // Returns a frame with index and times of 0. `depth` has the size of the depth camera. `color`
  // has the size of the colour camera, or of the depth camera if colour is registered; it may be
  // empty. Throws on other sizes. Depth is the nearest pixel, because interpolation invents values
  // at edges. Colour is bilinear, and has no occlusion test: background near depth edges can get
  // the colour of the foreground.
  RgbdFrame Rectify(const RawDepth& depth, Image<Rgb8> color) const;

 private:
  struct Tables;
  std::unique_ptr<const Tables> tables_;
};

// Corrects a depth image (m) of an undistorted camera by the field. The image must have the size of
// the camera, which is not checked. 0 (missing) stays 0. Depth becomes 0 if the corrected inverse
// depth is at most InverseDepthField::kMinInverse.
void CorrectDepth(const PinholeCamera& camera, const InverseDepthField& field,
                  Image<float>* depth_m);

}  // namespace surfit
