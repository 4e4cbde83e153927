#pragma once

#include <vector>

#include "surfit/geometry/rigid3.h"

namespace surfit {

// A camera pose with its time: x_world = world_from_camera * x_camera.
struct StampedPose {
  double stamp_s = 0;
  Rigid3d world_from_camera;
};

// Poses in ascending order of time.
using Trajectory = std::vector<StampedPose>;

}  // namespace surfit
