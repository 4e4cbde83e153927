#pragma once

#include "mapping/rendering/blended_view.h"
#include "surfit/frame/camera_motion.h"
#include "surfit/geometry/pinhole_camera.h"

namespace surfit {

// Capture times of image rows in a rolling shutter, relative to the time of a rendered view.
struct RowTimes {
  double middle_s = 0;   // middle row
  double readout_s = 0;  // from the first row to the last row
};

// Margin on each side of a rendered view, for surfaces that enter the view during the readout.
inline constexpr int kRollMargin_px = 32;
PinholeCamera WithRollMargin(PinholeCamera camera);

// Rolling-shutter view, resampled from a view that was rendered with the margin. `motion` is in the
// camera frame: a static point X is at X - t (turn x X + velocity) at time t. Colour is
// interpolated bilinearly between pixels with surface. Depth is taken from the nearest pixel.
BlendedView Rolled(const BlendedView& with_margin, const PinholeCamera& camera,
                   const CameraMotion& motion, const RowTimes& times);

}  // namespace surfit
