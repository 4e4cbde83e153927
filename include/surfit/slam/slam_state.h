#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "surfit/frame/rgbd_frame.h"
#include "surfit/geometry/inverse_depth_field.h"
#include "surfit/loop_closure/keyframe.h"
#include "surfit/mapping/surfel_map.h"
#include "surfit/poses/pose_store.h"

namespace surfit {

// State of SLAM with loops enabled after a frame. Another Slam continues from it.
struct SlamState : StoredPoses {
  // Views of the keyframes. Empty: given up, or not ready. Empty views are not relocalised.
  std::vector<PlaceView> views;
  std::optional<DepthCalibration> calibration;  // none: as given
  double color_latency_s = 0;                   // beyond the given one
  // What the camera is calibrated by, of each keyframe; empty where it stays as it was found.
  std::vector<std::shared_ptr<const RgbdFrame>> calibration_frames;
  SurfelMap map;
};

// What a Slam is to do with a state.
enum class StateUse {
  kContinue,  // go on: map, poses and keyframes grow
  kLocalize   // find the camera in it: the state stays as it is
};

}  // namespace surfit
