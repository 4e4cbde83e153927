#include "simulation/turn.h"

#include <cmath>

namespace surfit {

// By the half-angle formulas (1 + cos a, sin a * axis) = 2 cos(a/2) (cos(a/2), sin(a/2) * axis),
// with cos a = z . d and sin a * axis = z x d.
Eigen::Quaterniond TurnZInto(const Eigen::Vector3d& direction) {
  const Eigen::Vector3d d = direction.normalized();
  if (d.z() < -1 + 1e-12) return {0, 1, 0, 0};  // upside down, about the x axis
  return Eigen::Quaterniond(1 + d.z(), -d.y(), d.x(), 0).normalized();
}

}  // namespace surfit
