#pragma once

#include "surfit/geometry/trajectory.h"
#include "surfit/simulation/scene.h"

namespace surfit {

// What a depth camera of 640 x 480 pixels and a focal length of 525 px holds on to in one view.
// Only what lies 0.4 to 4.5 m away counts as seen.
struct ViewQuality {
  double seen_share = 0;        // of the pixels
  double two_planes_share = 0;  // of the seen pixels: those on the two largest flat faces

  bool IsPlanar() const { return two_planes_share >= 0.8; }
  // Leaves a depth camera without hold.
  bool IsBare() const { return two_planes_share > 0.95 || seen_share < 0.5; }
};

ViewQuality JudgeView(const Scene& scene, const Rigid3d& world_from_camera);

// What a camera path shows, judged by some of its frames.
struct PathQuality {
  double planar_share = 0;  // of the views
  double bare_share = 0;    // of the views
};

PathQuality JudgePath(const Scene& scene, const Trajectory& path);

}  // namespace surfit
