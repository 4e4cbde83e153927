#pragma once

#include <optional>
#include <string>
#include <vector>

#include "io/sequences/recording.h"
#include "surfit/geometry/pinhole_camera.h"

namespace surfit {

// Where edges of colour lie to the places where depth jumps.
struct RegistrationFit {
  double scale = 1;  // how much larger colour is than depth, about the middle of the image
  int right_px = 0, down_px = 0;  // and then by how much it is moved; to some pixels
  bool is_doubtful = false;       // all frames, and each half of them, speak against what is given
};

// Nothing where no frame tells.
std::optional<RegistrationFit> FitRegistration(const std::vector<FrameImages>& frames,
                                               const PinholeCamera& depth_camera);

// A sentence of warning if colour that should lie on depth's pixels hardly does, with the colour
// camera that would fit. Where depth jumps, an object ends, and colour mostly changes too. The mean
// change of colour at these pixels is largest where colour lies as it should; it is tried for
// colour that is up to a quarter larger or smaller, and moved by up to a twentieth of the width.
// Frames of few jumps tell nothing.
std::optional<std::string> RegistrationDoubt(const std::vector<FrameImages>& frames,
                                             const PinholeCamera& depth_camera);

}  // namespace surfit
