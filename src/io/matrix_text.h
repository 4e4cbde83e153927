#pragma once

#include <string>
#include <vector>

#include "io/text_rows.h"
#include "surfit/geometry/rigid3.h"

namespace surfit {

// The rigid transform of a 4 x 4 matrix. Throws InputError naming the place unless its upper left
// is a rotation (to 1 %, as files of few decimals have it).
Rigid3d RigidFromMatrix(const Eigen::Matrix4d& matrix, const std::string& place);

// The rigid transform in the rows [first, first + 4) of a text file, a 4 x 4 matrix. Throws
// InputError naming the place unless they are four rows of four finite numbers, or as
// RigidFromMatrix().
Rigid3d ParseRigid(const std::vector<TextRow>& rows, std::size_t first, const std::string& path);

}  // namespace surfit
