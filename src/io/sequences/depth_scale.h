#pragma once

#include <optional>
#include <string>

#include "surfit/frame/prepare_frame.h"

namespace surfit {

// Returns a warning if the depth scale is implausible: a median depth outside of 0.4 to 5 m, or
// nearly all depth below the range of sensors. The warning names the common scale that fits best.
// Returns std::nullopt for depth in metres (float images) and for images without valid depth.
std::optional<std::string> DepthScaleWarning(const RawDepth& depth, double depth_units_per_metre,
                                             const std::string& path);

}  // namespace surfit
