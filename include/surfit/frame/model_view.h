#pragma once

#include <cstdint>

#include "surfit/core/image.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/geometry/rigid3.h"

namespace surfit {

// What the map predicts a camera sees from a pose: where mapping and registration meet.
struct ModelView {
  static constexpr std::int32_t kNoSurfel = -1;

  Rigid3d world_from_view;
  FrameLevel surface;                // in the view's camera frame
  Image<std::int32_t> surfel_index;  // ids in the map; kNoSurfel where nothing is seen
};

}  // namespace surfit
