#pragma once

#include <string>

#include "surfit/geometry/trajectory.h"

namespace surfit {

// Writes a PNG of the camera's path from above and from the side, in metres along the world's axes,
// with equal scale on both axes of a view. ground_truth may be empty; where it is not, the caller
// has aligned the two. The vertical axis is the world axis nearest to the cameras' mean upward (-y)
// axis. Throws InputError where the file cannot be written.
void WriteTrajectoryPicture(const Trajectory& estimate, const Trajectory& ground_truth,
                            const std::string& path);

}  // namespace surfit
