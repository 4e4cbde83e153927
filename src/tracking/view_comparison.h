#pragma once

#include <algorithm>
#include <cstdint>

#include "surfit/core/image.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/registration/error_model.h"

namespace surfit {

// Views are compared on a grid of about 80 columns: a cell stands for step x step pixels, by the
// one in its middle.
struct ViewGrid {
  explicit ViewGrid(const PinholeCamera& camera)
      : step(std::max(1, camera.width / 80)),
        width(camera.width / step),
        height(camera.height / step) {}

  int Pixel(int cell) const { return cell * step + step / 2; }

  int step, width, height;
};

// Where a point of a frame lies to the surface that the model shows there.
enum class Side : std::uint8_t { kUnknown, kAtSurface, kInFront, kBehind };

// What a frame and the model show of each other at a pose.
struct ViewComparison {
  Image<Side> sides;  // of the frame's cells
  int points = 0;     // cells with depth
  int compared = 0;   // of these, those where the model shows a surface
  int in_front = 0;   // of these, those well in front of it,
  int behind = 0;     // and those well behind it: the frame sees through the surface
  double alike = 1;   // correlation of brightness at the surface; 1 where there is nothing to tell

  // Of the cells of a mask, those in front of the model.
  int CountInFront(const Image<std::uint8_t>& mask) const;
};

// Well in front or behind is beyond kFreeSpaceSigmas of the error model, along the model's normal.
// `model_grey` is the brightness of the model's cells, 0 where there is none; it may be empty, and
// so may `color`.
ViewComparison CompareViews(const FrameLevel& frame, const Image<Rgb8>& color,
                            const FrameLevel& model, const Image<float>& model_grey,
                            const ErrorModel& error_model, const Rigid3d& model_from_frame);

}  // namespace surfit
