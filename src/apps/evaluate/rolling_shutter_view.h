#pragma once

#include "mapping/rendering/blended_view.h"
#include "surfit/frame/camera_motion.h"
#include "surfit/geometry/pinhole_camera.h"

namespace surfit {

// Capture times of rolling-shutter rows, relative to the time of a rendered view.
struct RowTimes {
  double middle_s = 0;   // middle row
  double readout_s = 0;  // for all rows
};

// Surfaces in the margin can enter the view during the readout.
inline constexpr int kRollMargin_px = 32;
// Camera with kRollMargin_px more pixels on each side.
PinholeCamera WithRollMargin(PinholeCamera camera);

// Resamples a view of WithRollMargin(camera) as a rolling-shutter view. With `motion`, a static
// point X is at X - t (turn x X + velocity) in the camera frame at time t. Colour: bilinear
// interpolation between pixels with depth. Depth: nearest pixel, at the time of the view. `camera`:
// camera of the result, without margin. Pixels without depth are black.
BlendedView Rolled(const BlendedView& with_margin, const PinholeCamera& camera,
                   const CameraMotion& motion, const RowTimes& times);

}  // namespace surfit
