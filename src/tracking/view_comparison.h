#pragma once

#include <algorithm>
#include <cstdint>

#include "surfit/core/image.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/registration/error_model.h"

namespace surfit {

// Grid of about 80 columns for the comparison of views. A cell has step x step pixels and uses
// the values of its centre pixel.
struct ViewGrid {
  explicit ViewGrid(const PinholeCamera& camera)
      : step(std::max(1, camera.width / 80)),
        width(camera.width / step),
        height(camera.height / step) {}

  int Pixel(int cell) const { return cell * step + step / 2; }

  int step, width, height;
};

// Position of a frame point relative to the model surface.
enum class Side : std::uint8_t { kUnknown, kAtSurface, kInFront, kBehind };

struct ViewComparison {
  Image<Side> sides;  // per cell of the frame
  int points = 0;     // cells with depth
  int compared = 0;   // cells with depth and a model surface
  int in_front = 0;   // cells clearly in front of the model
  int behind = 0;     // cells clearly behind the model: free-space violations
  double alike = 1;   // correlation of brightness at the surface; 1 if it cannot be computed

  int CountInFront(const Image<std::uint8_t>& mask) const;
};

// Compares a frame with the model. "Clearly": farther than kFreeSpaceSigmas of the error model
// from the surface, along its normal. `model_grey`: brightness per model cell, 0 if unknown.
// `model_grey` and `color` may be empty.
ViewComparison CompareViews(const FrameLevel& frame, const Image<Rgb8>& color,
                            const FrameLevel& model, const Image<float>& model_grey,
                            const ErrorModel& error_model, const Rigid3d& model_from_frame);

}  // namespace surfit
