#pragma once

#include <deque>
#include <vector>

#include "cost_functions/analytic_relative_pose.h"
#include "refinement/reduced_system.h"

namespace surfit {

// What the given poses say: each keyframe lies where it did as the one before sees it, with
// standard deviations of its own. Keyframes that share few surfels would otherwise be moved by the
// errors of these.
class MotionPrior {
 public:
  // Says nothing.
  MotionPrior() = default;
  MotionPrior(const std::vector<Rigid3d>& world_from_camera, double sigma_m, double sigma_rad);

  // The variance of the observations, in the error model's: the prior counts as much more, as its
  // own standard deviations are true ones.
  void SetWeight(double weight) { weight_ = weight; }

  // Sum of the weighted rho: twice its part of the cost.
  double Rho(const JointState& state) const;
  // Adds its normal equations to those of poses and calibration.
  void AddTo(const JointState& state, ReducedSystem* system) const;

 private:
  std::deque<AnalyticRelativePose> edges_;  // from each keyframe to the next
  double weight_ = 1;
};

}  // namespace surfit
