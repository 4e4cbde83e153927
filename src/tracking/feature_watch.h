#pragma once

#include <optional>

#include "registration/global/feature_points.h"
#include "surfit/frame/camera_motion.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/registration/global_registration.h"
#include "tracking/moving_regions.h"

namespace surfit {

// Finest level with at most 400 columns, for the tracking of corners.
const FrameLevel& SmallLevel(const FramePyramid& pyramid);
// Brightness at the resolution of SmallLevel(). The view must have colour.
GreyPyramid GreyOf(const ColoredView& view);

// Result of a feature check: corners of two frames, classified by their poses.
struct FeatureMotion {
  int consistent_count = 0;       // corners whose motion agrees with the poses
  int apart = 0;                  // corners that agree on one second rigid motion; 0: none
  bool is_second_behind = false;  // corners of the second motion have the larger median depth

  // Returns whether enough corners agree on the second motion: 12 corners and 25 % of both counts,
  // or 7 corners and 50 %. The poses may be relative to a moving object.
  bool HasTwoMotions() const;
  // Returns whether more corners support the second motion than the poses. Background corners
  // count twice, because moving objects are usually in front of the static scene.
  bool IsRejected() const {
    return HasTwoMotions() && (is_second_behind ? 2 : 1) * apart > consistent_count;
  }
};

// Pose of a frame, and its camera motion since the previous frame with a pose.
struct MovingPose {
  Rigid3d world_from_camera;
  CameraMotion motion;  // zero: unknown
};

// Classifies point correspondences by the poses. Points are in camera coordinates, m. Corresponding
// points have equal indices, so both sets must have the same size (not checked). The tolerance is 3
// cm plus 3 sigma, plus the camera motion in 0.03 s, because depth and colour have different
// capture times. Returns zeros without points.
FeatureMotion CompareMotions(const FeaturePoints& source, const MovingPose& source_frame,
                             const FeaturePoints& target, const MovingPose& target_frame);

// Checks poses by image features. Geometric registration can follow a near moving object in front
// of flat walls. An object that moves from the first frame on causes no free-space violations. The
// check interval grows from 0.5 s to 8 s. A check more than 1 s after the previous check cannot be
// compared. It only stores the frame, and the next check follows after 0.5 s. Requires colour:
// without it, all counts are 0. Not thread-safe. Times are timestamps of the frames, s.
class FeatureWatch {
 public:
  explicit FeatureWatch(const ErrorModel& error_model) : error_model_(error_model) {}

  // Tracks the corners of the last checked frame in a new frame. Call for each frame before
  // Check(). `world_from_camera`: pose of the frame, predicts the corner positions; std::nullopt if
  // lost. Forgets the corners without colour, and more than 1 s after the last check.
  void Follow(const ColoredView& view, const std::optional<Rigid3d>& world_from_camera,
              double stamp_s);
  // True if a check is due at this time, before the first check, and after a rejection.
  bool IsDue(double stamp_s) const { return was_apart_ || !last_ || stamp_s >= due_s_; }
  // Compares a tracked frame with the last checked frame. Returns zeros without a checked frame in
  // the last 1 s. The frame becomes the last checked frame, unless its pose is rejected. After a
  // rejection, IsDue() is true until a pose is accepted. `moving`: cells whose depth is ignored;
  // empty: none. Call only for frames with a pose.
  FeatureMotion Check(const ColoredView& view, const CellMask& moving, const MovingPose& frame,
                      double stamp_s);
  // Forgets the last checked frame. Call if the world frame changes without a known correction.
  void Forget();
  // Applies a correction of the world frame to the stored poses.
  void Move(const Rigid3d& new_from_old_world);

 private:
  FeatureMotion Compare(const FrameLevel& surface, const MovingPose& frame) const;
  void Begin(const ColoredView& view, const FrameLevel& surface);

  ErrorModel error_model_;
  std::optional<MovingPose> last_;
  FeaturePoints points_;
  Rigid3d world_from_followed_;  // pose of the last tracked frame
  CornerTracks tracks_;
  double last_s_ = 0, begin_s_ = 0, due_s_ = 0;
  bool was_apart_ = false;
};

}  // namespace surfit
