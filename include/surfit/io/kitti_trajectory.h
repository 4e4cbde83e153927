#pragma once

#include <string>

#include "surfit/geometry/trajectory.h"

namespace surfit {

// Writes the poses as KITTI's odometry benchmark has them, atomically: a line a pose, the upper 3 x
// 4 of the camera-to-world matrix row by row, metres, 9 decimals. The format has no stamps. Throws
// InputError naming the file if it cannot be written.
void WriteKittiTrajectory(const Trajectory& trajectory, const std::string& path);

}  // namespace surfit
