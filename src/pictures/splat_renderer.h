#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "pictures/nearest_index_image.h"
#include "pictures/picture_view.h"
#include "surfit/mapping/surfel_map.h"

namespace surfit {

// The id of the surfel that each pixel of the view sees, NearestIndexImage::kNothing where none.
// Surfels are opaque discs: a pixel is covered where its ray meets the disc, and so is the pixel
// that holds the projected centre, so that none is lost between pixels. Surfels with shown[id] ==
// 0, those that face away from the camera and those nearer than two radii are not drawn.
Image<std::int32_t> RenderSurfels(const SurfelMap& map, const std::vector<std::uint8_t>& shown,
                                  const PictureView& view);

// The index of the point that each pixel sees; a point covers size_px x size_px pixels about its
// projection. Points are in the view's world.
Image<std::int32_t> RenderPoints(const std::vector<Eigen::Vector3f>& points_in_world, int size_px,
                                 const PictureView& view);

}  // namespace surfit
