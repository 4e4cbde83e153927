#pragma once

#include <optional>
#include <string>
#include <vector>

#include "io/recording.h"
#include "surfit/geometry/pinhole_camera.h"

namespace surfit {

// A sentence of warning if colour that should lie on depth's pixels hardly does, with the colour
// camera that would fit. Where depth jumps, an object ends, and colour mostly changes too. The mean
// change of colour at these pixels is largest where colour lies as it should; it is tried for
// colour that is up to a quarter larger or smaller, and moved by up to a twentieth of the width.
// Frames of few jumps tell nothing.
std::optional<std::string> RegistrationDoubt(const std::vector<FrameImages>& frames,
                                             const PinholeCamera& depth_camera);

}  // namespace surfit
