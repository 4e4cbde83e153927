#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "cost_functions/plane_inverse_depth.h"
#include "optimization/refinement/joint_rows.h"
#include "optimization/refinement/joint_state.h"
#include "optimization/refinement/shared_surfels.h"

namespace surfit {

// Sparsity pattern of the reduced system. Pairs of poses with a block: poses that share a
// surfel, consecutive poses (JointPrior), and each pose with itself.
class BlockPattern {
 public:
  static constexpr std::int32_t kNoBlock = -1;

  BlockPattern(const SharedSurfels& shared, std::size_t pose_count);

  int pose_count() const { return pose_count_; }
  std::size_t block_count() const { return block_count_; }

  // Index of the block of two poses, or kNoBlock. Requires row >= column.
  std::int32_t IndexOf(int row, int column) const { return indices_[PairOf(row, column)]; }

 private:
  static std::size_t PairOf(int row, int column) {
    return static_cast<std::size_t>(row) * (row + 1) / 2 + column;
  }

  int pose_count_;
  std::size_t block_count_ = 0;
  std::vector<std::int32_t> indices_;  // lower triangle, by rows
};

// Normal equations of poses and calibration with eliminated surfel parameters. Unknowns are the
// perturbation (w, v) of each pose (ProductPoseManifold), and then the calibration parameters:
//   hessian = A^T W A - A^T W b (b^T W b)^-1 b^T W A,
//   gradient = A^T W r - A^T W b (b^T W b)^-1 b^T W r.
// The rows are J = [A b], with the derivatives b by the surfel parameters. The weights are W =
// diag(rho'(r^2)). b^T W b is block diagonal, because each observation has one surfel. BlockPattern
// defines the pairs of poses with a block.
struct ReducedSystem {
  using PoseMatrix = Eigen::Matrix<double, kPoseTangentSize, kPoseTangentSize>;
  using MixedMatrix = Eigen::Matrix<double, kCalibrationSize, kPoseTangentSize>;
  using CalibrationMatrix = Eigen::Matrix<double, kCalibrationSize, kCalibrationSize>;

  // Keeps a pointer to the pattern.
  explicit ReducedSystem(const BlockPattern& block_pattern);
  // Both systems must have the same pattern.
  ReducedSystem& operator+=(const ReducedSystem& other);

  // Requires a pair with a block, and row >= column.
  PoseMatrix& PoseBlock(int row, int column) { return poses[pattern->IndexOf(row, column)]; }
  Eigen::Index CalibrationBegin() const { return gradient.size() - kCalibrationSize; }

  const BlockPattern* pattern;
  std::vector<PoseMatrix> poses;   // in the order of the pattern; diagonal blocks: lower triangle
  std::vector<MixedMatrix> mixed;  // cross blocks of calibration and pose, per pose
  CalibrationMatrix calibration = CalibrationMatrix::Zero();
  Eigen::VectorXd gradient;  // 6 values per pose, then kCalibrationSize
  double rho = 0;            // sum of rho: twice the cost
};

// Residuals of one surfel at a state. Refers to `shared` and to the state of `placed`, which must
// outlive it.
class SurfelResiduals {
 public:
  SurfelResiduals(const SharedSurfels& shared, const SharedSurfel& surfel,
                  const PlacedPoses& placed);

  const std::vector<PlaneResidual>& planes() const { return planes_; }
  const std::vector<TextureResidual>& textures() const {
    return textures_;
  }  // empty without texture

  // Optimal surfel parameters, by reweighted Gauss-Newton from a displacement of 0.
  SurfelParameters Best(const JointKernels& kernels) const;
  // Sums over the residuals at Best().
  JointFit FitOf(const JointKernels& kernels) const;

 private:
  std::vector<PlaneResidual> planes_;
  std::vector<TextureResidual> textures_;
};

// Sums over all surfels at their optimal parameters. The result is the same for any number of
// threads.
JointFit FitOf(const SharedSurfels& shared, const JointState& state, const JointKernels& kernels);

// Computes the reduced system at the optimal surfel parameters. `pattern` must be the pattern of
// `shared`. The result is the same for any number of threads.
ReducedSystem Reduce(const SharedSurfels& shared, const BlockPattern& pattern,
                     const JointState& state, const JointKernels& kernels);

}  // namespace surfit
