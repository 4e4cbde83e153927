#pragma once

#include <string>
#include <utility>
#include <vector>

#include "surfit/core/image.h"
#include "surfit/frame/frame_pyramid.h"
#include "surfit/frame/rgbd_frame.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/registration/icp.h"

namespace surfit {

// Frame-to-model tracking: options and outcomes. The states are documented in
// src/tracking/tracking_state.h.

// ICP options for tracking. The symmetric residual reduces the bias of point-to-plane residuals
// at creases, where normals mix both sides. 160 image rows are sufficient, because point noise
// does not dominate the error.
inline IcpOptions TrackingIcpOptions() {
  IcpOptions icp;
  icp.residual = "symmetric_point_to_plane";
  icp.min_source_rows = 160;
  return icp;
}

// Options of tracking. Names, bounds and their validation: SlamOptions::Visit(). Slam throws
// InputError for invalid options.
struct TrackingOptions {
  IcpOptions icp = TrackingIcpOptions();
  std::string tracking = "frame_to_model";  // or "frame_to_frame"
  // Maximum image shift since the last model view, fused frame or tracked frame, as a ratio of the
  // image width, at the mean depth. A larger shift triggers a new view, fusion, or verification by
  // global registration.
  double max_view_shift = 0.1;
  // A frame is weakly constrained if it is degenerate, or if its smallest IcpResult::eigenvalues is
  // below this bound.
  // The next frame then gets its own view, is registered with all rows, and is fused. 0:
  // never.
  double min_turn_eigenvalue = 2e-3;
  // ErrorModel::photometric_weight for weakly constrained frames; 0: geometric residuals only.
  // Photometric residuals move these frames only along directions with an eigenvalue below
  // 2.5 min_turn_eigenvalue. Ignored if icp.error_model has a photometric weight.
  double weakly_constrained_photometric_weight = 0.3;
  // Standard deviation of each acceleration component, for the motion prior. 1 to 4 m/s^2 for
  // hand-held cameras. 0: 3 m/s^2, and the prior changes the poses of weakly constrained frames
  // only. It is not used with an inertial sensor, or if icp.error_model has a photometric weight.
  double acceleration_m_per_s2 = 0;
  double angular_acceleration_rad_per_s2 = 4;
  // Bounds of an accepted registration: IcpResult::inlier_ratio and IcpResult::rmse_m. In fast
  // turns, half of a frame shows new surfaces, which have no inliers.
  double min_inlier_ratio = 0.25;
  double max_rmse_m = 0.03;
  // Frames with a lower inlier ratio are verified by features or global registration, as are frames
  // after a jump or a loss. 0: only lost and uncertain frames are searched; with place recognition,
  // not globally.
  double confident_inlier_ratio = 0.4;
  // Global registration of lost frames to the last frame with a pose: an
  // InitializeOptions::method. "identity": none. The pose is verified by registration to the
  // map.
  std::string initialize = "features";

  bool IsFrameToFrame() const { return tracking == "frame_to_frame"; }
  // Frames are verified by a second registration from the last frame, see confident_inlier_ratio.
  bool VerifiesBySearch() const { return confident_inlier_ratio > 0 && initialize != "identity"; }
};

// Comparison of prior poses (Slam::UsePriorPoses()) with registration.
struct PriorPoseSummary {
  int frames_compared = 0;  // tracked frames with a prior motion since the last tracked frame
  int frames_without = 0;   // tracked frames without a prior motion: no prior pose at their times
  int frames_used = 0;      // frames whose registration begins at the prior
  int frames_rejected = 0;  // frames of `rejected`
  // Times of the first and the last frame of each stretch that contradicts the registered motion.
  std::vector<std::pair<double, double>> rejected;
  Rigid3d body_from_camera;  // estimated offset
  // Estimated standard deviation of the drift of the prior after 1 s, per component.
  double sigma_m = 0, sigma_rad = 0;
};

// Outcome of a frame.
enum class FrameState {
  kFirst,        // first frame with sufficient depth, at the initial pose
  kTracked,      // registered
  kDegenerate,   // registered; depth leaves directions open, which follow colour and prediction
  kDuplicate,    // duplicate depth image: pose of the last frame, not fused
  kGiven,        // fused at a given pose, not tracked
  kLost,         // no pose, not fused
  kRelocalized,  // relocalised by a keyframe
  kNewMap,       // first frame of a new submap: see LoopOptions::new_map_after
};

// "first", "tracked", "degenerate", "duplicate", "given", "lost", "relocalised", "new_map".
std::string ToString(FrameState state);

// Lost frame with its failed registration. The references are valid during the callback of
// Slam::OnLostFrame() only. Source: the frame. Target: the view of the map, or of the last
// frame.
struct LostFrame {
  int index = 0;
  const FramePyramid& source;
  const FramePyramid& target;
  const Image<Rgb8>& source_color;  // size of the finest level; may be empty
  const Image<Rgb8>& target_color;  // of a map view: empty without photometric residuals
  Rigid3d target_from_source_initial;
  const IcpResult& icp;
  const IcpOptions& icp_options;  // of the first registration of the frame
};

}  // namespace surfit
