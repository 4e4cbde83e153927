#pragma once

#include "refinement/reduced_system.h"

namespace surfit::testing {

// All of a reduced hessian: poses, then calibration.
inline Eigen::MatrixXd DenseHessian(const ReducedSystem& system) {
  const BlockPattern& pattern = *system.pattern;
  const Eigen::Index size = system.gradient.size();
  Eigen::MatrixXd lower = Eigen::MatrixXd::Zero(size, size);
  lower.bottomRightCorner<kCalibrationSize, kCalibrationSize>() = system.calibration;
  for (int row = 0; row < pattern.pose_count(); ++row) {
    const int begin = kPoseTangentSize * row;
    lower.block<kCalibrationSize, kPoseTangentSize>(system.CalibrationBegin(), begin) =
        system.mixed[row];
    for (int column = 0; column <= row; ++column) {
      const auto block = pattern.IndexOf(row, column);
      if (block == BlockPattern::kNoBlock) continue;
      lower.block<kPoseTangentSize, kPoseTangentSize>(begin, kPoseTangentSize * column) =
          system.poses[block];
    }
  }
  return lower.selfadjointView<Eigen::Lower>();
}

}  // namespace surfit::testing
