#pragma once

#include <Eigen/Core>

#include "cost_functions/plane_inverse_depth.h"
#include "cost_functions/pose.h"

namespace surfit {

// How many numbers are found of a surfel: its displacement, and with texture two of that.
inline constexpr int kPlaneUnknowns = 1;
inline constexpr int kTexturedUnknowns = 3;

using PoseRow = Eigen::Matrix<double, kPoseTangentSize, 1>;
using CalibrationRow = Eigen::Matrix<double, kCalibrationSize, 1>;
template <int kUnknowns>
using SurfelRow = Eigen::Matrix<double, kUnknowns, 1>;

// A surfel's own numbers.
struct SurfelNumbers {
  double displacement = 0;                            // m, along its normal
  Eigen::Vector2d texture = Eigen::Vector2d::Zero();  // in standard deviations
};

// A residual and its derivatives by the pose's increment (w, v) of ProductPoseManifold, the
// calibration and the displacement.
struct JointRow {
  double residual = 0;
  PoseRow by_pose;
  CalibrationRow by_calibration;
  double by_displacement = 0;
};

}  // namespace surfit
