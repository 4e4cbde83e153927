#pragma once

#include <optional>
#include <string>
#include <vector>

#include "io/sequences/recording.h"
#include "surfit/frame/rectify_frame.h"
#include "surfit/geometry/sensor.h"

namespace surfit {

// Encodings of depth that files do not name. They are detected from the first images of a
// recording, and removed from all images.
struct DepthEncoding {
  bool has_swapped_bytes = false;  // of 16-bit counts
  bool is_rotated = false;         // 16-bit counts, rotated left by 3 bits as in SUN3D
  double float_unit_m = 1;         // unit of float images, m
  // Value of pixels without a measurement, after the other corrections. std::nullopt: only the
  // values that RawDepth names.
  std::optional<double> fill_value;

  bool IsPlain() const {
    return !has_swapped_bytes && !is_rotated && float_unit_m == 1 && !fill_value;
  }
};

// Detects the encoding of the first images, which belong to one recording and have one pixel type.
// Adds a warning for each detected property. The encoding is plain without images, and for a
// disparity camera.
// - Swapped bytes: neighbouring pixels are much more similar with swapped bytes.
// - Rotated: almost all counts are multiples of 8, and the depth is plausible only without the
//   rotation.
// - Floats in mm: the median is above 100, which no depth camera measures in m.
// - Fill value: the smallest or largest value is much more frequent than neighbouring values. It
//   occurs in several images, and the camera moves.
DepthEncoding DetectDepthEncoding(const std::vector<FrameImages>& images, const RgbdCamera& camera,
                                  std::vector<std::string>* warnings);

// Converts an image to counts or metres. Fill values become 0, and 65535 (missing) stays.
void DecodeDepth(const DepthEncoding& encoding, RawDepth* depth);

// Returns a warning if more than a fifth of the depth is beyond max_depth_m. `images` are decoded.
// std::nullopt otherwise, for a disparity camera, and without depth.
std::optional<std::string> FarDepthWarning(const std::vector<FrameImages>& images,
                                           const RgbdCamera& camera, double max_depth_m);

}  // namespace surfit
