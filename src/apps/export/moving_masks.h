#pragma once

#include <cstdint>

#include "surfit/core/image.h"
#include "surfit/geometry/pinhole_camera.h"
#include "surfit/geometry/rigid3.h"

namespace surfit {

// Pixels of a depth image whose surface is in front of the map: objects that have moved and are not
// part of the map. 255: in front, 0: other pixels. `map_depth_m` is the map at the pose of the
// image, 0 without a surface. A part is at least 10 cm plus 2 % of the depth in front of the map,
// and has at least 0.5 % of the pixels. Both images must have equal sizes.
Image<std::uint8_t> PixelsInFront(const Image<float>& depth_m, const Image<float>& map_depth_m);

// Mask of a colour image: 0 where pixels of `in_front` project to, else 255. The mask of an object
// is closed and dilated by 1 % of the image width. `depth_m` is the image of `in_front`, by
// `depth_camera`. Returns an image without zeros if nothing is in front.
Image<std::uint8_t> MaskOfColor(const Image<std::uint8_t>& in_front, const Image<float>& depth_m,
                                const PinholeCamera& depth_camera, const Rigid3d& color_from_depth,
                                const PinholeCamera& lens);

// Mask of an undistorted image: 0 where a pixel of the mask of the distorted image contributes.
Image<std::uint8_t> UndistortMask(const Image<std::uint8_t>& mask, const PinholeCamera& distorted,
                                  const PinholeCamera& lens);

}  // namespace surfit
