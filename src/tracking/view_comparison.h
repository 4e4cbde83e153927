#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "surfit/core/image.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/registration/error_model.h"

namespace surfit {

// Grid of 80 to 159 columns for the comparison of views. A cell has step x step pixels and uses the
// values of its centre pixel. Images below 160 columns have one cell per pixel.
struct ViewGrid {
  explicit ViewGrid(const PinholeCamera& camera)
      : step(std::max(1, camera.width / 80)),
        width(camera.width / step),
        height(camera.height / step) {}

  int Pixel(int cell) const { return cell * step + step / 2; }
  // Index of the cell with the pixel, or -1.
  int CellOf(const Eigen::Vector2d& pixel) const {
    const double x = std::floor((pixel.x() + 0.5) / step), y = std::floor((pixel.y() + 0.5) / step);
    const bool is_inside = x >= 0 && y >= 0 && x < width && y < height;
    return is_inside ? static_cast<int>(y) * width + static_cast<int>(x) : -1;
  }

  int step, width, height;
};

// Position of a frame point relative to the model surface. Without depth, outside of the model view
// or without a model surface, it is kUnknown. Within the bound of CompareViews(), it is kAtSurface.
enum class Side : std::uint8_t { kUnknown, kAtSurface, kInFront, kBehind };

// Result of CompareViews(). All counts are numbers of frame cells.
struct ViewComparison {
  Image<Side> sides;  // per cell of the frame
  int points = 0;     // cells with depth
  int compared = 0;   // cells with depth and a model surface
  int in_front = 0;   // cells clearly in front of the model
  int behind = 0;     // cells clearly behind the model: free-space violations
  double alike = 1;   // correlation of brightness at the surface, in [-1, 1]; 1 if unknown

  // Number of cells in front of the model with a nonzero mask. An empty mask gives 0.
  int CountInFront(const Image<std::uint8_t>& mask) const;
};

// Compares a frame with the model. "Clearly": farther than kFreeSpaceSigmas (5) standard deviations
// from the surface, along its normal. `color`: image of the frame with the size of this level;
// empty: `alike` is 1. `model_grey`: brightness per cell of the model view, 0 if unknown; may be
// empty. `alike` is also 1 with fewer than 200 compared cells, or without texture.
// `model_from_frame` maps points of the frame camera to the model camera, m.
ViewComparison CompareViews(const FrameLevel& frame, const Image<Rgb8>& color,
                            const FrameLevel& model, const Image<float>& model_grey,
                            const ErrorModel& error_model, const Rigid3d& model_from_frame);

}  // namespace surfit
