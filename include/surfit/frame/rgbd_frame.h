#pragma once

#include "surfit/core/image.h"

namespace surfit {

// One depth image with its colours. The images are undistorted, share their pixels and belong to
// one pinhole camera; color may be empty where the sequence has none.
struct RgbdFrame {
  int index = 0;  // position in the sequence, counted from 0 over all its frames
  // The moment that depth shows, and a pose of the frame holds for: its stamp less the sensor's
  // latency (RgbdCamera). Colour's likewise, less the same latency; the same without colour.
  double stamp_s = 0;
  double color_stamp_s = 0;
  Image<float> depth_m;  // z along the optical axis in metres; 0 = missing, all else finite and > 0
  Image<Rgb8> color;     // (0, 0, 0) where the colour camera does not see the depth pixel
};

}  // namespace surfit
