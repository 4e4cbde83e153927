#pragma once

#include <array>
#include <memory>

#include "cost_functions/pose_manifold.h"
#include "cost_functions/reduced_batch.h"
#include "registration/icp/photometric_term.h"
#include "surfit/core/robust_kernel.h"
#include "surfit/registration/error_model.h"
#include "surfit/registration/normal_system.h"
#include "surfit/registration/pairs.h"

namespace surfit {

// All pairs as one ReducedBatch over the residual's functor, in the precision of the pairs, whose
// arrays must be of their size. The pose block starts at the identity: see functor_batch.h.
template <typename S>
std::unique_ptr<ReducedBlock> MakeReducedCost(Pairs<S> pairs, ResidualType residual,
                                              const RobustKernel& kernel);

// The same of intensities.
std::unique_ptr<ReducedBlock> MakeReducedCost(const IntensityPairs& pairs,
                                              const PhotometricTerm& term);

using PoseBlock = std::array<double, kPoseSize>;

inline PoseBlock IdentityBlock() { return {0, 0, 0, 1, 0, 0, 0}; }

// The left increment from the identity to a pose.
inline Vector6d AsIncrement(const PoseBlock& pose) {
  Vector6d increment;
  LeftPoseManifold().Minus(pose.data(), IdentityBlock().data(), increment.data());
  return increment;
}

// What Levenberg-Marquardt stops at: in single precision what its sums can meet, far below what
// moves an association; in double precision the rounding of the cost.
template <typename S>
struct LmTolerances {
  static constexpr bool kSingle = sizeof(S) == sizeof(float);
  static constexpr double kFunction = kSingle ? 1e-9 : 1e-16;
  static constexpr double kGradient = kSingle ? 1e-10 : 1e-14;
  static constexpr double kParameter = kSingle ? 1e-8 : 1e-13;
  static constexpr int kMaxIterations = 50;
};

}  // namespace surfit
