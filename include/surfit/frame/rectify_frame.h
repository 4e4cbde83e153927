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

// Raw depth image: depth along the optical axis, or disparities if RgbdCamera::disparity is given.
// - std::uint16_t: counts of 1/depth_units_per_metre or of the disparity; 0 and 65535 are missing.
// - float: metres or counts of the disparity; NaN, infinity, 0 and negative values are missing.
using RawDepth = std::variant<Image<std::uint16_t>, Image<float>>;

// Selection of pixels and depths.
struct RectifyOptions {
  int downsample = 1;      // keep every downsample-th column and row
  double max_depth_m = 8;  // larger depths are missing, because their noise is too high

  void Visit(OptionVisitor& visitor);
};

// Converts the images of an RGB-D camera to frames: removes distortion, registers colour to depth
// and downsamples. All tables are computed once. Prepare() may be called from several threads.
class FrameRectifier {
 public:
  // Throws InputError if the options or the camera are invalid, if fy < 0 (see Mirrored() in
  // sensor.h), or if an image has less than 2 x 2 pixels.
  FrameRectifier(const RgbdCamera& camera, const RectifyOptions& options);
  FrameRectifier(FrameRectifier&&) noexcept;
  ~FrameRectifier();

  // Camera of the frames: the depth camera without distortion, subsampled by `downsample`.
  const PinholeCamera& pinhole() const;

  // Prepares a frame without index and timestamps. The depth image has the size of the depth
  // camera. The colour image has the size of the colour camera, or of the depth camera if colour is
  // registered; it may be empty. Aborts on other sizes. Depth is taken from the nearest pixel,
  // because interpolation invents values at edges. Colour is bilinear.
  RgbdFrame Rectify(const RawDepth& depth, Image<Rgb8> color) const;

 private:
  struct Tables;
  std::unique_ptr<const Tables> tables_;
};

// Corrects a depth image of an undistorted camera, in m, by the field. Depth is missing (0) if the
// corrected inverse depth is not above InverseDepthField::kMinInverse.
void CorrectDepth(const PinholeCamera& camera, const InverseDepthField& field,
                  Image<float>* depth_m);

}  // namespace surfit
