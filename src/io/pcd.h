#pragma once

#include <string>
#include <string_view>

#include "surfit/io/point_cloud.h"

namespace surfit {

// The cloud in the bytes of a PCD file: x y z of any type, normal_x normal_y normal_z where there
// are all three, rgb or rgba of four bytes. VIEWPOINT is not applied.
// Throws InputError naming `path` and what is wrong with it.
PointCloud ParsePcd(std::string_view file, const std::string& path);

}  // namespace surfit
