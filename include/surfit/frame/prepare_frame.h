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

// Depth along the optical axis as a sensor or file gives it: counts of 1/depth_units_per_metre, 0
// and 65535 meaning missing, or metres, where what is not finite or not positive is missing; or
// both as disparities, where the camera tells their formula.
using RawDepth = std::variant<Image<std::uint16_t>, Image<float>>;

// Which pixels and depths of a camera's images are used.
struct PrepareOptions {
  int downsample = 1;      // keep every downsample-th column and row
  double max_depth_m = 8;  // depth beyond is missing: noise there outgrows what it could tell

  void Visit(OptionVisitor& visitor);
};

// Turns the images of an RGB-D camera into frames whose depth and colour share the pixels of one
// pinhole camera: undistorted, colour registered to depth, every downsample-th pixel kept. All
// that does not depend on the images is worked out once, and only the kept pixels are computed.
class FramePreparer {
 public:
  // Throws InputError unless the options and the camera are valid, fy > 0 (see geometry/mirror.h)
  // and the images at least 2 x 2 pixels.
  FramePreparer(const RgbdCamera& camera, const PrepareOptions& options);
  FramePreparer(FramePreparer&&) noexcept;
  ~FramePreparer();

  // The camera of the frames: the depth camera's fx fy cx cy without its distortion, subsampled.
  const PinholeCamera& pinhole() const;

  // Takes images of the depth camera's and of the colour camera's size (the depth camera's where
  // colour is registered to it); color may be empty. Depth is the nearest pixel's, so that no
  // value across an edge is invented; colour is bilinear. Index and stamp are left to the caller.
  RgbdFrame Prepare(const RawDepth& depth, Image<Rgb8> color) const;

 private:
  struct Tables;
  std::unique_ptr<const Tables> tables_;
};

// Corrects the depth of an undistorted camera's pixels (m, 0 = missing) by the field at their rays.
// What then has no finite positive depth is missing.
void CorrectDepth(const PinholeCamera& camera, const InverseDepthField& field,
                  Image<float>* depth_m);

}  // namespace surfit
