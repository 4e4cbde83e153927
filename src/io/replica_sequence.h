#pragma once

#include <string>

#include "surfit/geometry/pinhole_camera.h"

namespace surfit {

// cam_params.json of the folder, or of the one above it (as NICE-SLAM's download has it), or else
// the preset `replica`. Throws InputError naming the file if it is malformed.
RgbdCamera ReplicaCamera(const std::string& folder);

}  // namespace surfit
