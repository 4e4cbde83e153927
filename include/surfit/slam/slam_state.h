#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "surfit/frame/rgbd_frame.h"
#include "surfit/geometry/inverse_depth_field.h"
#include "surfit/loop_closure/keyframe.h"
#include "surfit/mapping/surfel_map.h"
#include "surfit/optimization/pose_graph.h"
#include "surfit/slam/backend.h"

namespace surfit {

// What SLAM with loops enabled knows after a frame: enough for another Slam to go on from there.
struct SlamState {
  std::vector<PosedFrame> frames;       // all with a pose, by ascending index; one at least
  std::vector<KeyframeLink> keyframes;  // by ascending frame; parents stand before
  // Of the keyframes. Empty ones cannot be found again: they were given up, or not made in time.
  std::vector<PlaceView> views;
  std::vector<PoseGraphEdge> edges;   // between keyframes, by their positions: odometry and loops
  std::vector<bool> loops_in_graph;   // of each edge that is a loop: consistent with the others
  std::size_t settled_keyframes = 0;  // the first so many have been looked at for loops
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
