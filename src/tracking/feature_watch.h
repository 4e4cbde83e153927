#pragma once

#include <optional>
#include <vector>

#include "registration/global/feature_points.h"
#include "surfit/frame/camera_motion.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/registration/far_registration.h"
#include "tracking/moving_regions.h"

namespace surfit {

// What the corners that two frames share say of the motion between their poses.
struct FeatureMotion {
  int as_posed = 0;              // so many have moved as the poses say,
  int apart = 0;                 // and so many otherwise, all by one other motion,
  bool is_apart_behind = false;  // which are mostly behind the others

  // Two motions explain the views, and the poses may be those against what moves.
  bool IsApart() const;
  // More corners say that the poses are wrong than that they are right. What hides the scene stands
  // before it: of what is behind, half as many tell as much.
  bool IsRefuted() const { return IsApart() && (is_apart_behind ? 2 : 1) * apart > as_posed; }
};

// A frame's pose, and how fast the camera moves.
struct MovingPose {
  Rigid3d world_from_camera;
  CameraMotion motion;
};

// How points, of which the i-th of both is one, have moved, against the poses. These are those of
// depth, and colours are of another moment: the faster the camera, the farther may corners be from
// where they are expected.
FeatureMotion CompareMotions(const FeaturePoints& source, const MovingPose& source_frame,
                             const FeaturePoints& target, const MovingPose& target_frame);

// Shapes alone may hold the camera at something near that moves, and the walls behind it slide
// along themselves: where that is so from the first frame on, nothing has ever been seen through
// it. The images tell. They are looked at twice a second in the beginning, and every few seconds
// later.
class FeatureWatch {
 public:
  explicit FeatureWatch(const ErrorModel& error_model) : error_model_(error_model) {}

  // Each frame, before it is checked: follows the corners of the last one that was looked at, from
  // where the motion from the frame before expects them, if the frame has a pose.
  void Follow(const ColoredView& view, const std::optional<Rigid3d>& world_from_camera,
              double stamp_s);
  bool IsDue(double stamp_s) const { return was_apart_ || !last_ || stamp_s >= due_s_; }
  // Compares the frame that was followed with the last one that was looked at, if that is not long
  // ago, and takes its place unless its pose is refuted. Then each frame is due, until one is not.
  FeatureMotion Check(const ColoredView& view, const CellMask& moving, const MovingPose& frame,
                      double stamp_s);
  // The world has been corrected.
  void Move(const Rigid3d& new_from_old_world);

 private:
  FeatureMotion Compare(const FrameLevel& surface, const MovingPose& frame) const;
  // Corners of a frame, which are followed from there on.
  void Begin(const ColoredView& view, const FrameLevel& surface);

  ErrorModel error_model_;
  std::optional<MovingPose> last_;
  FeaturePoints points_;         // of the last frame's corners
  Rigid3d world_from_followed_;  // pose of the frame that was followed last
  CornerTracks tracks_;
  double last_s_ = 0, begin_s_ = 0, due_s_ = 0;
  bool was_apart_ = false;
};

}  // namespace surfit
