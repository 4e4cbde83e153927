#pragma once

#include <optional>

#include "surfit/frame/rgbd_frame.h"
#include "surfit/registration/icp.h"
#include "surfit/tracking/tracking.h"
#include "tracking/model_views.h"
#include "tracking/moving_regions.h"
#include "tracking/tracking_state.h"

namespace surfit {

// Result of the validation of a registered pose.
enum class Verdict {
  kAccepted,   // residuals, surfaces and brightness agree with the pose
  kUncertain,  // accepted if a second registration agrees with the pose
  kRejected,   // failed registration or wrong pose
};

// Pose of a lost frame. The next frame confirms or rejects the pose.
struct TentativePose {
  RgbdFrame frame;     // measured frame without moving objects
  ReferenceView view;  // view of `frame`; view.world_from_view is the pose
  IcpResult icp;
  int keyframe = -1;        // keyframe of the relocalisation; -1: none
  int keyframe_frame = -1;  // its frame index
  int submap = 0;           // of the pose
};

// Outcome of a frame. The first frame, a frame with a given pose and a duplicate have no
// registration, so `icp` has its defaults.
struct Tracked {
  FrameState state = FrameState::kLost;
  Rigid3d world_from_camera;  // undefined if lost
  IcpResult icp;
  Verdict verdict = Verdict::kAccepted;  // of the last registration
  // Brightness contradicts the pose, and all checks of depth agree with it.
  bool is_color_contradicted = false;
  // The previous frame has a pose, the motion is as predicted, and depth constrains all directions.
  bool is_certain_by_depth = false;
  FrameQuality quality;
  bool found_by_search = false;  // pose from PoseSearch
  bool has_second = false;       // two registrations agree on the pose
  int keyframe = -1;             // keyframe of the relocalisation; -1: none
  int keyframe_frame = -1;       // its frame index
  std::optional<int> submap;     // of the pose; std::nullopt: the submap of the last pose
  bool has_own_view = false;     // the reference view was rendered for this frame
  CellMask moving;               // moving cells: neither registered nor fused
  double moving_ratio = 0;       // moving cells / cells with depth
  double behind_ratio = 0;       // cells behind the model / compared cells
  bool has_two_motions = false;  // see FeatureMotion; false if the check did not run
  // Registered pose without any prior, and its information (1/rad^2, 1/m^2): left perturbation of
  // the identity in the camera frame. Directions that depth may not constrain have none. Zero
  // information: no direction is known, or not registered.
  Rigid3d world_from_registered;
  Matrix6d registered_information = Matrix6d::Zero();
  // Covariance (rad, m) of the registered pose without any prior: left perturbation of the identity
  // in the camera frame, relative to the map. See CovarianceByBlocks(). std::nullopt if not
  // registered, or if a direction is unobservable.
  std::optional<Matrix6d> registered_covariance;
  // Covariance of the motion to this frame, in the camera frame. Only with a motion prior.
  std::optional<Matrix6d> motion_covariance;
  // Squared difference of the registered from the predicted pose, in standard deviations. 0 without
  // a motion prior.
  double prior_squared_difference = 0;
  std::optional<TentativePose> tentative;  // set if the frame is lost with a tentative pose
  std::optional<TentativePose> confirmed;  // confirmed pose of the previous frame

  bool has_pose() const { return state != FrameState::kLost; }
};

}  // namespace surfit
