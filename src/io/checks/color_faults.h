#pragma once

#include <optional>
#include <string>
#include <vector>

#include "io/sequences/recording.h"

namespace surfit {

// Returns the reason why colour of a recording cannot belong to its depth, or std::nullopt.
// Reasons: all images are noise, or one image repeats while depth changes. `images`: frames that
// are about 0.5 s apart. At least three frames with colour are required.
std::optional<std::string> ColorFault(const std::vector<FrameImages>& images);

}  // namespace surfit
