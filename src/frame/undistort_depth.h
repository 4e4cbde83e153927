#pragma once

#include <cstdint>

#include "surfit/core/image.h"
#include "surfit/frame/prepare_frame.h"
#include "surfit/geometry/pinhole_camera.h"

namespace surfit {

// For each pixel of the undistorted, downsampled image: the index of the nearest pixel of the
// camera's own image, or -1 where the camera does not see it.
Image<std::int32_t> NearestPixels(const PinholeCamera& camera, int downsample);

// Metres at the given pixels of the raw image; 0 where depth is missing or beyond max_depth_m.
Image<float> DepthAt(const Image<std::int32_t>& pixels, const RawDepth& raw,
                     double depth_units_per_metre, double max_depth_m);

}  // namespace surfit
