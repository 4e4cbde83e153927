#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "registration/global/feature_points.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/registration/global_registration.h"
#include "tracking/motion/static_motion.h"
#include "tracking/moving_regions.h"

namespace surfit {

// Detects moving objects by image corners. Detection needs no map and no pose, so objects may move
// since the first frame. Requires colour. Not thread-safe. Times are timestamps, s.
class MovingCorners {
 public:
  // Begins or extends a watch: corners are followed until 2 s after this time.
  void Watch(double stamp_s);
  // Tracks the corners to a frame. Call for each frame. Without a watch, the frame has no corners.
  void Follow(const ColoredView& view, double stamp_s);
  // Returns the moving cells of the frame of Follow(), if the static corners contradict this pose,
  // or contradicted a pose in the last second. Otherwise, returns an empty mask: the registration
  // finds the static scene.
  CellMask Contradicting(const std::optional<Rigid3d>& world_from_camera);
  // Stores the pose of the frame of Follow(). std::nullopt: lost.
  void Remember(const std::optional<Rigid3d>& world_from_camera);
  // Forgets the poses, not the corners. Call if the world frame changes without a known correction.
  void Forget();
  // Applies a correction of the world frame to the stored pose.
  void Move(const Rigid3d& new_from_old_world);

 private:
  // Corners of one frame, tracked to the present frame.
  struct Window {
    CornerTracks tracks;
    std::vector<Eigen::Vector3d> points;  // per corner, in the first camera
    std::vector<bool> moved_before;       // per corner: on a moving cell of the first frame
    Rigid3d now_from_first;               // motion of the static scene
    double first_s = 0;
    bool is_young = true;                     // no frame was compared with the first frame
    std::optional<Rigid3d> world_from_first;  // std::nullopt: lost
  };

  void Compare(const ColoredView& view, const GreyPyramid& grey);
  CellMask MovingCells(const ColoredView& view) const;
  Window Begun(const ColoredView& view, GreyPyramid grey, double stamp_s) const;

  std::optional<Window> window_;
  std::optional<Window> next_;  // begins at the last frame
  Rigid3d step_;                // last motion of the static scene from frame to frame
  double last_s_ = 0;
  double watched_until_s_ = -std::numeric_limits<double>::infinity();
  bool is_followed_ = false;  // the last frame
  double contradicted_until_s_ = -std::numeric_limits<double>::infinity();
  // Results for the last frame. Empty: not compared.
  PinholeCamera camera_;
  std::vector<TrackedCorner> corners_;
  CornerMotion motion_;
  CellMask moving_;
};

}  // namespace surfit
