#pragma once

#include "cost_functions/pose_error.h"

namespace surfit {

// Prior Z of a pose X with an information matrix (1/rad^2, 1/m^2), six residuals. X is the
// parameter block (pose.h), target_from_source like Z. The error X Z^-1 is the left perturbation (w
// [rad], v [m]) from Z to X, in the target frame. Residuals are in standard deviations, see
// WhitenedPoseError.
class PosePrior {
 public:
  PosePrior(const Rigid3d& prior, const PoseInformation& information)
      : inverse_prior_(prior.Inverse()), whiten_(information) {}

  template <typename T>
  bool operator()(const T* pose, T* residuals) const {
    whiten_(PoseFromBlock(pose) * inverse_prior_.cast<T>(), residuals);
    return true;
  }

 private:
  Rigid3d inverse_prior_;
  WhitenedPoseError whiten_;
};

}  // namespace surfit
