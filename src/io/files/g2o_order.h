#pragma once

namespace surfit {

// Order of (rotation, translation) for the order of g2o: (translation, rotation), (x, y, z), (x, y,
// angle) and (x, y).
inline constexpr int kPoseOrder[] = {3, 4, 5, 0, 1, 2}, kPositionOrder[] = {0, 1, 2};
inline constexpr int kPlanarOrder[] = {3, 4, 2};

}  // namespace surfit
