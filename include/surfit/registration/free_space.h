#pragma once

#include "surfit/frame/frame_pyramid.h"
#include "surfit/geometry/rigid3.h"
#include "surfit/registration/error_model.h"

namespace surfit {

// A point farther in front of a surface than so many sigmas contradicts it.
inline constexpr double kFreeSpaceSigmas = 5;

// How far the source contradicts the target at a pose: a source point p' in front of the surface
// (vertex q, normal n facing the camera) at the target pixel it projects to fills space that the
// target camera saw through. Returns the share of points with r > kFreeSpaceSigmas * sigma among
// those with r >= -kFreeSpaceSigmas * sigma,
//   r = n . (p' - q),  sigma^2 = floor_sigma_m^2 + sigma_z(p'_z)^2 + sigma_z(q_z)^2.
// Points behind may be hidden and say nothing, nor do pixels without a normal (missing depth, depth
// edges); 0 where no point says anything. Two views of a rigid scene hardly contradict each other
// at the true pose, while a fit of some surfaces to others leaves the rest in each other's free
// space.
double FreeSpaceShare(const FrameLevel& source, const FrameLevel& target,
                      const ErrorModel& error_model, const Rigid3d& target_from_source);

}  // namespace surfit
