#pragma once

#include <Eigen/Geometry>
#include <vector>

namespace surfit {

// Rotations of up to 60 degrees, the nearest to none first: their rotation vectors are a
// body-centred cubic lattice, at most 11 degrees from any rotation in between.
std::vector<Eigen::Quaterniond> RotationGrid();

}  // namespace surfit
