#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "cost_functions/plane_inverse_depth.h"
#include "optimization/refinement/joint_rows.h"
#include "optimization/refinement/joint_state.h"
#include "optimization/refinement/shared_surfels.h"

namespace surfit {

// Which pairs of poses the reduced system ties: those that share a surfel, and each pose with
// itself and the next one (JointPrior). Others have no block.
class BlockPattern {
 public:
  static constexpr std::int32_t kNoBlock = -1;

  BlockPattern(const SharedSurfels& shared, std::size_t pose_count);

  int pose_count() const { return pose_count_; }
  std::size_t block_count() const { return block_count_; }

  // The index of the block of two poses, row >= column, or kNoBlock. Blocks are numbered row by
  // row. The table takes 4 bytes for each pair, 1 / 72 of what its block would.
  std::int32_t IndexOf(int row, int column) const { return indices_[PairOf(row, column)]; }

 private:
  static std::size_t PairOf(int row, int column) {
    return static_cast<std::size_t>(row) * (row + 1) / 2 + column;
  }

  int pose_count_;
  std::size_t block_count_ = 0;
  std::vector<std::int32_t> indices_;  // of the lower triangle, row by row
};

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

// All that keyframes at one state see of a surfel.
class SurfelSight {
 public:
  SurfelSight(const SharedSurfels& shared, const SharedSurfel& surfel, const PlacedPoses& placed);

  const std::vector<PlaneSight>& planes() const { return planes_; }
  const std::vector<TextureSight>& textures() const { return textures_; }  // empty without texture

  // Those for which its observations agree best, from no displacement on.
  SurfelNumbers Best(const JointKernels& kernels) const;
  // How far its observations are from those.
  JointFit FitOf(const JointKernels& kernels) const;

 private:
  std::vector<PlaneSight> planes_;
  std::vector<TextureSight> textures_;
};

JointFit FitOf(const SharedSurfels& shared, const JointState& state, const JointKernels& kernels);

// At the surfels' best numbers; the pattern is that of these surfels. The same at any number of
// threads.
ReducedSystem Reduce(const SharedSurfels& shared, const BlockPattern& pattern,
                     const JointState& state, const JointKernels& kernels);

}  // namespace surfit
