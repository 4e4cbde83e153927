#pragma once

#include <ceres/problem.h>

#include <memory>
#include <vector>

#include "cost_functions/analytic_relative_pose.h"
#include "optimization/refinement/joint_rows.h"
#include "optimization/refinement/reduced_system.h"

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
  // Adds its residuals to a problem that owns neither these nor losses; both must outlive it.
  void AddTo(const std::vector<double*>& poses, double* calibration,
             std::vector<std::unique_ptr<ceres::LossFunction>>* losses,
             ceres::Problem* problem) const;

 private:
  CalibrationRow ChangeOf(const DepthCalibration& calibration) const;

  std::vector<std::unique_ptr<AnalyticRelativePose>> edges_;  // from each keyframe to the next
  std::unique_ptr<ceres::CostFunction> residuals_;            // of the calibration, or none
  CalibrationRow given_ = CalibrationRow::Zero();
  ReducedSystem::CalibrationMatrix information_ = ReducedSystem::CalibrationMatrix::Zero();
  double weight_ = 1;
};

// A round's problem: surfels and who sees them, which stay the same throughout.
struct JointProblem {
  const SharedSurfels& shared;
  const JointPrior& prior;
  JointKernels kernels;
};

inline constexpr int kNoSolution = -1;

// What a solver did.
struct JointReport {
  int iterations = 0;  // steps tried, or kNoSolution where the cost is not finite
  // At poses and calibration of the start and after each accepted step.
  std::vector<double> costs;
  double build_ms = 0;      // what a solver is given
  double linearize_ms = 0;  // one linearisation
  double solve_ms = 0;      // all but building
};

// Which of the calibration's eleven numbers are not to change.
std::vector<bool> HeldCalibration(const RefinementOptions& options);

// Moves poses, but for the first, and the free calibration to the least cost, by
// Levenberg-Marquardt, with the options' solver. Leaves the state as it was where there is no
// solution. The same at any number of threads.
JointReport MinimizeJointly(const JointProblem& problem, const RefinementOptions& options,
                            JointState* state);

// "reduced": the surfels' own numbers are at their best for poses and calibration at every step.
// Steps are those of Ceres' trust region (Nielsen's rule for the damping).
JointReport MinimizeReduced(const JointProblem& problem, const RefinementOptions& options,
                            JointState* state);

// "ceres": a ceres::Problem of the functors of PlaneInverseDepth and SurfelTexture, by autodiff,
// whose unknowns the surfels' own numbers are as well. Ceres eliminates these first, and solves the
// Schur complement as the options' linear solver says. On one thread: with more, Ceres sums costs
// and gradients in no fixed order.
JointReport MinimizeWithCeres(const JointProblem& problem, const RefinementOptions& options,
                              JointState* state);

}  // namespace surfit
