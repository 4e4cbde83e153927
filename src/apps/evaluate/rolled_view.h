#pragma once

#include "mapping/rendering/blended_view.h"
#include "surfit/frame/camera_motion.h"
#include "surfit/geometry/pinhole_camera.h"

namespace surfit {

// When a camera has read the rows of an image: the middle one so long after the moment of a picture
// of the map, the others before and after it.
struct RowTimes {
  double middle_s = 0;
  double readout_s = 0;
};

// A camera that sees so many pixels more on each side, to draw what comes into view meanwhile.
inline constexpr int kRollMargin_px = 32;
PinholeCamera WithRollMargin(PinholeCamera camera);

// A picture that was drawn with that margin, as the camera shows it that moves while it reads the
// rows: a point X that stands still is at X - t (turn x X + velocity) a time t after the picture's
// moment. Colours are bilinear between pixels that show the map, depth is the nearest pixel's.
BlendedView Rolled(const BlendedView& with_margin, const PinholeCamera& camera,
                   const CameraMotion& motion, const RowTimes& times);

}  // namespace surfit
