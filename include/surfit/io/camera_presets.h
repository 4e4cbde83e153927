#pragma once

#include <string>
#include <vector>

#include "surfit/geometry/sensor.h"

namespace surfit {

// The cameras of well-known data sets, 640 x 480: tum_fr1, tum_fr2, tum_fr3, icl_nuim (fy < 0, as
// published), seven_scenes (colour camera not registered to depth), redwood, replica (1200 x 680,
// as rendered for NICE-SLAM), klg (ElasticFusion's default). Throws InputError listing the known
// names for any other.
RgbdCamera CameraPreset(const std::string& name);

std::vector<std::string> CameraPresetNames();

}  // namespace surfit
