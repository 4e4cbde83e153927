#pragma once

#include "cost_functions/pose_error.h"

namespace surfit {

// Pose graph edge with six residuals: measurement a_from_b with an information matrix (1/rad^2,
// 1/m^2). The parameter blocks are world_from_a and world_from_b (pose.h). The error
// (world_from_a^-1 world_from_b) a_from_b^-1 is the left perturbation (w [rad], v [m]) from the
// measurement to the estimate, in frame a. Residuals are in standard deviations, see
// WhitenedPoseError.
class RelativePose {
 public:
  RelativePose(const Rigid3d& a_from_b, const PoseInformation& information)
      : b_from_a_(a_from_b.Inverse()), whiten_(information) {}

  template <typename T>
  bool operator()(const T* world_from_a, const T* world_from_b, T* residuals) const {
    const Rigid3<T> a_from_b = PoseFromBlock(world_from_a).Inverse() * PoseFromBlock(world_from_b);
    whiten_(a_from_b * b_from_a_.cast<T>(), residuals);
    return true;
  }

 private:
  Rigid3d b_from_a_;
  WhitenedPoseError whiten_;
};

}  // namespace surfit
