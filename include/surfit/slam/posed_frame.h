#pragma once

#include "surfit/geometry/rigid3.h"

namespace surfit {

// A frame that has a pose, and what it hangs on.
struct PosedFrame {
  int index = 0;
  double stamp_s = 0;
  Rigid3d world_from_camera;  // as corrected so far
  int keyframe = 0;           // the last one before it, or itself
  // Frames of one stretch were tracked one after the other; relocalisation begins another one.
  int stretch = 0;
};

}  // namespace surfit
