#pragma once

#include <string>

#include "surfit/core/image.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/frame/rgbd_frame.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/registration/icp.h"

namespace surfit {

// Frame-to-model tracking: options and outcomes. Depends on registration. Read
// src/tracking/tracking_state.h first.

// Options of the ICP of consecutive frames: the symmetric residual. A normal near a crease mixes
// both sides, so point-to-plane residuals are biased in the direction of the camera motion. The
// sum of both normals reduces this bias. A third of 480 rows is sufficient, because the noise of
// single points does not dominate the error.
inline IcpOptions TrackingIcpOptions() {
  IcpOptions icp;
  icp.residual = "symmetric_point_to_plane";
  icp.min_source_rows = 160;
  return icp;
}

// Options of tracking. SlamOptions::Visit() lists their names and bounds.
struct TrackingOptions {
  IcpOptions icp = TrackingIcpOptions();
  std::string tracking = "frame_to_model";  // or "frame_to_frame"
  // Largest shift of the image since the last model view or fused frame, as a ratio of the image
  // width at the mean depth. A larger shift triggers a new view, fusion and global registration.
  double max_view_shift = 0.1;
  // Smallest value of IcpResult::eigenvalues of a sufficiently constrained frame. After a weakly
  // constrained frame, the next frame gets its own view, is registered with all rows, and is fused.
  double min_turn_eigenvalue = 2e-3;
  // ErrorModel::photometric_weight of weakly constrained frames. 0: geometric residuals only. Not
  // used if icp.error_model has a photometric weight.
  double weakly_constrained_photometric_weight = 0;
  // Initial pose: constant_velocity, constant_pose, or so3: the last pose with the rotation of
  // AlignRotation().
  std::string motion_model = "constant_velocity";
  // Standard deviation of each component of the acceleration, for the motion prior. Hand-held
  // recordings have 1 to 4 m/s^2. Requires constant_velocity. 0: no motion prior.
  double acceleration_m_per_s2 = 0;
  double angular_acceleration_rad_per_s2 = 4;
  // Bounds of an accepted registration.
  double min_inlier_ratio = 0.3;
  double max_rmse_m = 0.03;
  // Frames below this inlier ratio are verified by global registration, as are frames after a jump
  // or a loss. 0: only lost frames are searched.
  double confident_inlier_ratio = 0.4;
  // Global registration of lost frames to the last frame with a pose: InitializeOptions::method.
  // identity: none. The map must agree with the found pose.
  std::string initialize = "features";

  bool IsFrameToFrame() const { return tracking == "frame_to_frame"; }
  // Uncertain frames are searched as well as lost frames.
  bool VerifiesBySearch() const { return confident_inlier_ratio > 0 && initialize != "identity"; }
};

// Outcome of a frame.
enum class FrameState {
  kFirst,        // first frame with sufficient depth, at the initial pose
  kTracked,      // registered
  kDegenerate,   // registered, and unobservable directions keep the predicted pose
  kDuplicate,    // duplicate depth image: pose of the last frame, not fused
  kGiven,        // fused at a given pose, not tracked
  kLost,         // no pose, not fused
  kRelocalized,  // found by a keyframe
  kNewMap,       // first frame of a new submap: see LoopOptions::new_map_after
};

// "first", "tracked", "degenerate", "duplicate", "given", "lost", "relocalised", "new_map".
std::string ToString(FrameState state);

// A lost frame with its failed registration. The references are valid during the call only.
struct LostFrame {
  int index = 0;
  const FramePyramid& source;
  const FramePyramid& target;
  const Image<Rgb8>& source_color;  // pixels of the finest level; may be empty
  const Image<Rgb8>& target_color;  // colours of the map; empty without photometric residuals
  Rigid3d target_from_source_initial;
  const IcpResult& icp;
};

}  // namespace surfit
