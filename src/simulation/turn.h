#pragma once

#include <Eigen/Geometry>

namespace surfit {

// The shortest turn that brings the z axis into a direction, of any length but zero.
Eigen::Quaterniond TurnZInto(const Eigen::Vector3d& direction);

}  // namespace surfit
