#pragma once

#include "frame/bilinear.h"
#include "surfit/core/image.h"
#include "surfit/geometry/sensor.h"

namespace surfit {

// Gives the pixels of the undistorted, downsampled depth image their colours. The point that a
// depth pixel sees, x = d ray, appears to the colour camera at color_from_depth * x = d R ray + t.
// Where that pixel does not depend on d (t = 0, or colour is registered to depth) it is looked up
// in a table; else pixels without depth have no colour. The colour camera is assumed to see what
// the depth camera sees: along occlusion edges, as wide as the parallax, it may see the foreground.
class ColorRegistration {
 public:
  ColorRegistration(const RgbdCamera& camera, int downsample);

  // color has the colour camera's size; depth_m the output's.
  Image<Rgb8> Apply(Image<Rgb8> color, const Image<float>& depth_m) const;

 private:
  // The taps of the points at these depths (m; 0 = none) on the rays of output row v.
  void FindTaps(int v, const float* depth_m, BilinearTap* taps) const;

  PinholeCamera pinhole_;  // of the output
  PinholeCamera color_;
  Eigen::Matrix3d rotation_;     // of color_from_depth
  Eigen::Vector3d translation_;  // m
  bool is_copy_;                 // each output pixel is the colour pixel at the same place
  Image<BilinearTap> taps_;      // empty where the tap depends on depth
};

}  // namespace surfit
