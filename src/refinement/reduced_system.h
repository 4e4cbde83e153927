#pragma once

#include <Eigen/Core>
#include <vector>

#include "cost_functions/plane_inverse_depth.h"
#include "refinement/block_pattern.h"
#include "refinement/joint_fit.h"
#include "refinement/joint_kernels.h"
#include "refinement/joint_state.h"

namespace surfit {

// The normal equations of poses and calibration, the surfels' own numbers eliminated: for the
// increments (w, v) of each pose, by ProductPoseManifold, and then of the calibration's ten
// numbers. With the rows J = [A b], b of the surfels' numbers, and weights W = diag(rho'(r^2)),
//   hessian = A^T W A - A^T W b (b^T W b)^-1 b^T W A,
//   gradient = A^T W r - A^T W b (b^T W b)^-1 b^T W r.
// b^T W b is block diagonal: each observation has one surfel. Poses that share no surfel have no
// block.
struct ReducedSystem {
  using PoseMatrix = Eigen::Matrix<double, kPoseTangentSize, kPoseTangentSize>;
  using MixedMatrix = Eigen::Matrix<double, kCalibrationSize, kPoseTangentSize>;
  using CalibrationMatrix = Eigen::Matrix<double, kCalibrationSize, kCalibrationSize>;

  // Zero. The pattern must outlive it.
  explicit ReducedSystem(const BlockPattern& block_pattern);
  ReducedSystem& operator+=(const ReducedSystem& other);

  // Of a pair that has one, row >= column.
  PoseMatrix& PoseBlock(int row, int column) { return poses[pattern->IndexOf(row, column)]; }
  // Where the calibration begins in the gradient.
  Eigen::Index CalibrationBegin() const { return gradient.size() - kCalibrationSize; }

  const BlockPattern* pattern;
  // The hessian: pairs of poses in the pattern's order, of whose diagonal blocks the lower triangle
  // counts; the calibration's rows of each pose; and the calibration's own.
  std::vector<PoseMatrix> poses;
  std::vector<MixedMatrix> mixed;
  CalibrationMatrix calibration = CalibrationMatrix::Zero();
  Eigen::VectorXd gradient;
  double rho = 0;  // the sum: twice the cost
};

JointFit FitOf(const SharedSurfels& shared, const JointState& state, const JointKernels& kernels);

// At the surfels' best numbers; the pattern is that of these surfels. The same at any number of
// threads.
ReducedSystem Reduce(const SharedSurfels& shared, const BlockPattern& pattern,
                     const JointState& state, const JointKernels& kernels);

}  // namespace surfit
