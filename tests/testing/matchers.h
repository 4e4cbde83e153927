#pragma once

#include <gmock/gmock.h>

#include <Eigen/Core>

#include "surfit/geometry/rigid3.h"

namespace surfit::testing {

// EXPECT_THAT(actual, VectorNear(expected, tolerance)): the Euclidean (for a matrix: Frobenius)
// distance is at most the tolerance. A NaN on either side never matches.
MATCHER_P2(VectorNear, expected, tolerance,
           "is within " + ::testing::PrintToString(tolerance) + " of (" +
               ::testing::PrintToString(expected) + ")") {
  const double distance = (arg - expected).norm();
  *result_listener << "off by " << distance;
  return distance <= tolerance;
}

// EXPECT_THAT(actual, RigidNear(expected, tolerance_m, tolerance_rad)): translation and rotation
// are that near; q and -q are the same rotation. A NaN on either side never matches.
MATCHER_P3(RigidNear, expected, tolerance_m, tolerance_rad,
           "is within " + ::testing::PrintToString(tolerance_m) + " m and " +
               ::testing::PrintToString(tolerance_rad) + " rad of\n" +
               ::testing::PrintToString(expected.Matrix())) {
  const double distance_m = (arg.translation - expected.translation).norm();
  const double angle_rad = RotationAngle(arg.rotation * expected.rotation.conjugate());
  *result_listener << "\n"
                   << arg.Matrix() << "\noff by " << distance_m << " m and " << angle_rad << " rad";
  return distance_m <= tolerance_m && angle_rad <= tolerance_rad;
}

}  // namespace surfit::testing
