#pragma once

#include "surfit/core/image.h"

namespace surfit {

// Depth and colour image with the same pixels, of an undistorted pinhole camera. `color` is empty
// if the sequence has no colour.
struct RgbdFrame {
  int index = 0;  // ReadResult::index; in a session plus SessionRun::shift
  // Capture times, s. Depth: timestamp - RgbdCamera::latency_s; the pose of the frame refers to
  // this time. Colour: timestamp - latency_s - color_latency_s; unspecified without colour.
  double stamp_s = 0;
  double color_stamp_s = 0;
  Image<float> depth_m;  // z along the optical axis, m; 0: missing; else finite and positive
  Image<Rgb8> color;     // (0, 0, 0): not visible to the colour camera
};

}  // namespace surfit
