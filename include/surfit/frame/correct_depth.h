#pragma once

#include "surfit/core/image.h"
#include "surfit/geometry/inverse_depth_field.h"
#include "surfit/geometry/pinhole_camera.h"

namespace surfit {

// Corrects the depth of an undistorted camera's pixels (m, 0 = missing) by the field at their rays.
// What then has no finite positive depth is missing.
void CorrectDepth(const PinholeCamera& camera, const InverseDepthField& field,
                  Image<float>* depth_m);

}  // namespace surfit
