#pragma once

#include <deque>
#include <vector>

#include "cost_functions/analytic_relative_pose.h"
#include "refinement/joint_rows.h"
#include "refinement/reduced_system.h"

namespace surfit {

// What is known before the observations, each with standard deviations of its own.
class JointPrior {
 public:
  // Says nothing.
  JointPrior() = default;
  // Each keyframe lies where it did as the one before sees it. Keyframes that share few surfels
  // would otherwise be moved by the errors of these.
  JointPrior(const std::vector<Rigid3d>& world_from_camera, double sigma_m, double sigma_rad);
  // The calibration is about the given one. What a recording does not show stays as it was.
  JointPrior(const DepthCalibration& given, const CalibrationPrior& prior);

  // The variance of the observations, in the error model's: the prior counts as much more, as its
  // own standard deviations are true ones.
  void SetWeight(double weight) { weight_ = weight; }

  // Sum of the weighted rho: twice its part of the cost.
  double Rho(const JointState& state) const;
  // Adds its normal equations to those of poses and calibration.
  void AddTo(const JointState& state, ReducedSystem* system) const;

 private:
  CalibrationRow ChangeOf(const DepthCalibration& calibration) const;

  std::deque<AnalyticRelativePose> edges_;  // from each keyframe to the next
  CalibrationRow given_ = CalibrationRow::Zero();
  ReducedSystem::CalibrationMatrix information_ = ReducedSystem::CalibrationMatrix::Zero();
  double weight_ = 1;
};

inline constexpr int kNoSolution = -1;

// Which of the calibration's ten numbers are not to change.
std::vector<bool> HeldCalibration(const RefinementOptions& options);

// Moves poses, but for the first, and the free calibration to the least cost, by
// Levenberg-Marquardt, with the same observations throughout. Returns the number of steps tried, or
// kNoSolution where the cost is not finite, which leaves the state as it was.
//
// Its steps are those of Ceres' trust region (Nielsen's rule for the damping): Ceres itself would
// have to be given a square root of the reduced hessian as Jacobian, a factorisation as costly as
// the solution, to multiply it out again.
int MinimizeJointly(const SharedSurfels& shared, const JointPrior& prior,
                    const JointKernels& kernels, const RefinementOptions& options,
                    JointState* state);

}  // namespace surfit
