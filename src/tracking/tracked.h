#pragma once

#include <optional>

#include "surfit/frame/rgbd_frame.h"
#include "surfit/registration/icp.h"
#include "surfit/tracking/tracking.h"
#include "tracking/model_views.h"
#include "tracking/moving_regions.h"
#include "tracking/tracking_state.h"

namespace surfit {

enum class Verdict {
  kAccepted,   // registration, surfaces and brightness agree with the pose
  kUncertain,  // accepted if a second registration agrees with the pose
  kRejected,   // wrong, or not constrained
};

// A lost frame with a pose that the next frame must confirm.
struct TentativePose {
  RgbdFrame frame;     // measured frame without moving objects
  ReferenceView view;  // view of `frame`; view.world_from_view is the pose
  IcpResult icp;
  int keyframe = -1;  // keyframe of the relocalisation; -1: none
};

struct Tracked {
  FrameState state = FrameState::kLost;
  Rigid3d world_from_camera;  // undefined if lost
  IcpResult icp;              // last registration
  Verdict verdict = Verdict::kAccepted;
  FrameQuality quality;
  bool found_by_search = false;  // found by search
  bool has_second = false;       // two registrations agree on the pose
  int keyframe = -1;             // keyframe of the relocalisation; -1: none
  bool has_own_view = false;     // the reference was rendered for this frame
  CellMask moving;               // not registered, not fused
  double moving_ratio = 0;       // moving cells / cells with depth
  double behind_ratio = 0;       // cells behind the model / compared cells
  bool has_two_motions = false;  // the feature check found two motions
  // Covariance of the motion to this frame, in the camera frame. Only with a motion prior.
  std::optional<Matrix6d> motion_covariance;
  std::optional<TentativePose> tentative;  // pose of this lost frame
  std::optional<TentativePose> confirmed;  // pose of the previous frame, confirmed by this frame

  bool has_pose() const { return state != FrameState::kLost; }
};

}  // namespace surfit
