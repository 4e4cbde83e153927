#pragma once

#include <Eigen/Geometry>

namespace surfit {

// The shortest turn that brings the z axis into a direction, of any length but zero.
// (Eigen's FromTwoVectors brings a singular value decomposition along, which takes half a minute to
// compile under sanitizers.)
Eigen::Quaterniond TurnZInto(const Eigen::Vector3d& direction);

}  // namespace surfit
