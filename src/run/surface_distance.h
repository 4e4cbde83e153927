#pragma once

#include <optional>

#include "surfit/frame/frame_pyramid.h"
#include "surfit/geometry/rigid3.h"

namespace surfit {

// The median of |n . (p' - q)| over projected pixels, in metres. Nothing if there is no pair of
// points within the default gates.
std::optional<double> MedianSurfaceDistance(const FrameLevel& source, const FrameLevel& target,
                                            const Rigid3d& target_from_source);

}  // namespace surfit
