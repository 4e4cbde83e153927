#pragma once

#include <string>

#include "surfit/geometry/pinhole_camera.h"

namespace surfit {

// A camera as Open3D writes it: JSON with width, height and the column-major 3 x 3
// intrinsic_matrix. Throws InputError naming the file and what is wrong.
PinholeCamera ReadOpen3dCamera(const std::string& path);

}  // namespace surfit
