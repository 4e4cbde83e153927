#pragma once

namespace surfit {

// Index of each g2o number in Surfit. kPoseOrder: (translation, rotation) in (rotation,
// translation). kPlanarOrder: (x, y, angle) in (rotation, translation). kPositionOrder: (x, y, z)
// and (x, y).
inline constexpr int kPoseOrder[] = {3, 4, 5, 0, 1, 2}, kPositionOrder[] = {0, 1, 2};
inline constexpr int kPlanarOrder[] = {3, 4, 2};

}  // namespace surfit
