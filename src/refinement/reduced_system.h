#pragma once

#include <Eigen/Core>
#include <vector>

#include "cost_functions/plane_inverse_depth.h"
#include "refinement/block_pattern.h"
#include "surfit/core/robust_kernel.h"

namespace surfit {

// What is to be found, but for the displacements.
struct JointState {
  std::vector<Rigid3d> world_from_camera;
  DepthCalibration calibration;
};

// The normal equations of poses and calibration, the displacements eliminated: for the increments
// (w, v) of each pose, by ProductPoseManifold, and then of the calibration's ten numbers. With the
// rows J = [A b], b of the surfels' displacements, and weights W = diag(rho'(r^2)),
//   hessian = A^T W A - A^T W b (b^T W b)^-1 b^T W A,
//   gradient = A^T W r - A^T W b (b^T W b)^-1 b^T W r.
// b^T W b is diagonal: each observation has one surfel. Poses that share no surfel have no block.
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

// How far the observations are from the planes at their best displacements.
struct JointFit {
  double rho = 0;             // the sum: twice the cost
  double weight = 0;          // the sum of rho'
  double squared_sigmas = 0;  // the sums, so weighted, of r^2
  double squared_metres = 0;  // and of the squared distances of points to planes

  JointFit& operator+=(const JointFit& other);
};

// The displacement of a surfel for which its observations agree best, from none on.
double BestDisplacement(const SharedSurfels& shared, const SharedSurfel& surfel,
                        const JointState& state, const RobustKernel& kernel);

JointFit FitOf(const SharedSurfels& shared, const JointState& state, const RobustKernel& kernel);

// At the best displacements; the pattern is that of these surfels. The same at any number of
// threads.
ReducedSystem Reduce(const SharedSurfels& shared, const BlockPattern& pattern,
                     const JointState& state, const RobustKernel& kernel);

}  // namespace surfit
