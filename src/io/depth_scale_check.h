#pragma once

#include <optional>
#include <string>

#include "surfit/frame/prepare_frame.h"

namespace surfit {

// A sentence of warning if the median of the valid depth is hardly that of a scene before a depth
// camera, with the scale in common use that would make it one. Depth in metres has no scale.
std::optional<std::string> DepthScaleWarning(const RawDepth& depth, double depth_units_per_metre,
                                             const std::string& path);

}  // namespace surfit
