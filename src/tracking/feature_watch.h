#pragma once

#include <optional>
#include <vector>

#include "registration/global/feature_points.h"
#include "surfit/frame/camera_motion.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/registration/global_registration.h"
#include "tracking/moving_regions.h"

namespace surfit {

// Motion of the corners that two frames share, compared with their poses.
struct FeatureMotion {
  int consistent_count = 0;       // corners that agree with the poses
  int apart = 0;                  // corners that agree on one other motion
  bool is_second_behind = false;  // the corners of the other motion are farther away

  // Returns whether the corners show two motions: the poses may be relative to a moving object.
  bool HasTwoMotions() const;
  // Returns whether most corners contradict the poses. Occluders are in front of the scene.
  // Therefore corners of the other motion count twice if they are in the background.
  bool IsRejected() const {
    return HasTwoMotions() && (is_second_behind ? 2 : 1) * apart > consistent_count;
  }
};

struct MovingPose {
  Rigid3d world_from_camera;
  CameraMotion motion;
};

// Compares the motion of corresponding points, with equal indices, with the poses. Poses refer to
// the capture time of depth. Colour has another capture time, so the tolerance grows with the
// camera motion.
FeatureMotion CompareMotions(const FeaturePoints& source, const MovingPose& source_frame,
                             const FeaturePoints& target, const MovingPose& target_frame);

// Checks poses by image features. Geometric registration can follow a near moving object while the
// walls behind it slide along themselves. If the object moves from the first frame, there are no
// free-space violations, but the images show the motion. Checks take place every 0.5 s in the
// beginning, and every few seconds later.
class FeatureWatch {
 public:
  explicit FeatureWatch(const ErrorModel& error_model) : error_model_(error_model) {}

  // Tracks the corners of the last checked frame. Call for each frame before Check(). The
  // prediction of the corners uses the motion since the previous frame, if the frame has a pose.
  void Follow(const ColoredView& view, const std::optional<Rigid3d>& world_from_camera,
              double stamp_s);
  bool IsDue(double stamp_s) const { return was_apart_ || !last_ || stamp_s >= due_s_; }
  // Compares a tracked frame with the last checked frame, if that is at most 1 s old. The frame
  // becomes the last checked frame, unless its pose is rejected. After a rejection, every frame is
  // checked until a pose is accepted.
  FeatureMotion Check(const ColoredView& view, const CellMask& moving, const MovingPose& frame,
                      double stamp_s);
  // Applies a correction of the world.
  void Move(const Rigid3d& new_from_old_world);

 private:
  FeatureMotion Compare(const FrameLevel& surface, const MovingPose& frame) const;
  // Detects corners in a frame, for tracking in the following frames.
  void Begin(const ColoredView& view, const FrameLevel& surface);

  ErrorModel error_model_;
  std::optional<MovingPose> last_;
  FeaturePoints points_;         // corners of the last checked frame
  Rigid3d world_from_followed_;  // pose of the last tracked frame
  CornerTracks tracks_;
  double last_s_ = 0, begin_s_ = 0, due_s_ = 0;
  bool was_apart_ = false;
};

}  // namespace surfit
