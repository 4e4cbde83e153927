#pragma once

#include <optional>
#include <string>

#include "surfit/frame/prepare_frame.h"

namespace surfit {

// Returns a warning if the depth scale is implausible and another common scale fits better, or if
// the median depth is below 0.2 m or above 20 m. Implausible: the median depth is outside of 0.4 to
// 5 m, or almost all depth is too close. Returns std::nullopt for depth in metres (float images)
// and for images without valid depth.
std::optional<std::string> DepthScaleWarning(const RawDepth& depth, double depth_units_per_metre,
                                             const std::string& path);

}  // namespace surfit
