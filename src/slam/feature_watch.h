#pragma once

#include <optional>

#include "registration/feature_points.h"
#include "slam/moving_regions.h"
#include "surfit/frame/camera_motion.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/registration/far_registration.h"

namespace surfit {

// What the features that two frames share say of the motion between their poses.
struct FeatureMotion {
  int as_posed = 0;  // so many have moved as the poses say,
  int apart = 0;     // and so many otherwise, all by one other motion

  // Two motions explain the views, and the poses may be those against what moves.
  bool IsApart() const;
  // More features say that the poses are wrong than that they are right.
  bool IsRefuted() const { return IsApart() && apart > as_posed; }
};

// Of a frame, at 400 columns or less, without what moves.
FeaturePoints FeaturesAtRest(const ColoredView& view, const CellMask& moving,
                             const ErrorModel& error_model);

// Features of a frame, its pose, and how fast the camera moves.
struct PosedFeatures {
  FeaturePoints features;
  Rigid3d world_from_camera;
  CameraMotion motion;
};

// How features have moved, against the poses. These are those of depth, and colours are of another
// moment: the faster the camera, the farther may features be from where they are expected.
FeatureMotion CompareFeatures(const PosedFeatures& source, const PosedFeatures& target);

// Shapes alone may hold the camera at something near that moves, and the walls behind it slide
// along themselves: where that is so from the first frame on, nothing has ever been seen through
// it. The images tell. They are looked at twice a second in the beginning, and every few seconds
// later.
class FeatureWatch {
 public:
  bool IsDue(double stamp_s) const { return was_apart_ || !last_ || stamp_s >= due_s_; }
  // Compares a frame with the last one that was looked at, if that is not long ago, and takes its
  // place unless its pose is refuted. Then each frame is due, until one is not.
  FeatureMotion Check(PosedFeatures frame, double stamp_s);
  // The world has been corrected.
  void Move(const Rigid3d& new_from_old_world);

 private:
  std::optional<PosedFeatures> last_;
  double last_s_ = 0, begin_s_ = 0, due_s_ = 0;
  bool was_apart_ = false;
};

}  // namespace surfit
