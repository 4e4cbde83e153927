#pragma once

#include "surfit/frame/rgbd_frame.h"
#include "surfit/registration/far_registration.h"

namespace surfit {

// A frame as tracking and fusion take it.
struct PreparedFrame {
  const RgbdFrame& images;
  ColoredView view;

  const FrameLevel& surface() const { return view.pyramid.levels.front(); }
};

// What a frame is registered to, and the pose that it is seen from.
struct ReferenceView {
  ColoredView view;  // its colours are the map's only where intensities count
  Rigid3d world_from_view;
};

}  // namespace surfit
