#pragma once

#include <ceres/problem.h>

#include <memory>
#include <vector>

#include "cost_functions/analytic_relative_pose.h"
#include "optimization/refinement/joint_rows.h"
#include "optimization/refinement/reduced_system.h"

namespace surfit {

// Prior of the relative keyframe poses, or of the calibration. A default object is no prior.
class JointPrior {
 public:
  JointPrior() = default;
  // Prior of the relative poses of consecutive keyframes. Its mean values are the relative poses of
  // `world_from_camera`. A Huber kernel of width 4 limits each edge.
  JointPrior(const std::vector<Rigid3d>& world_from_camera, double sigma_m, double sigma_rad);
  // Prior of the calibration about `given`. A parameter with a standard deviation of 0 has no
  // prior.
  JointPrior(const DepthCalibration& given, const CalibrationPrior& prior);

  // Sets the variance of the observations, relative to the error model. The cost of the prior
  // is multiplied by this variance.
  void SetWeight(double weight) { weight_ = weight; }

  // Sum of the weighted rho: twice the cost of the prior.
  double Rho(const JointState& state) const;
  // Adds Hessian, gradient and rho at a state with the keyframes of the constructor.
  void AddTo(const JointState& state, ReducedSystem* system) const;
  // Adds the residuals to a problem without ownership of cost and loss functions. The prior and
  // `losses` must outlive the problem. `poses` has one block per keyframe.
  void AddTo(const std::vector<double*>& poses, double* calibration,
             std::vector<std::unique_ptr<ceres::LossFunction>>* losses,
             ceres::Problem* problem) const;

 private:
  CalibrationRow ChangeOf(const DepthCalibration& calibration) const;

  std::vector<std::unique_ptr<AnalyticRelativePose>> edges_;  // between consecutive keyframes
  std::unique_ptr<ceres::CostFunction> residuals_;  // prior of the calibration; null: none
  CalibrationRow given_ = CalibrationRow::Zero();
  ReducedSystem::CalibrationMatrix information_ = ReducedSystem::CalibrationMatrix::Zero();
  double weight_ = 1;
};

// Observations, prior and robust kernels. References must outlive the object.
struct JointProblem {
  const SharedSurfels& shared;
  const JointPrior& prior;
  JointKernels kernels;
};

// JointReport::iterations if the initial cost is not finite or Ceres fails.
inline constexpr int kNoSolution = -1;

// Statistics of a minimisation.
struct JointReport {
  int iterations = 0;  // number of steps, with rejected ones; kNoSolution after a failure
  // Initial cost, and the cost after each accepted step. Empty without a solution.
  std::vector<double> costs;
  double build_ms = 0;      // setup of a Ceres problem; 0 for "reduced"
  double linearize_ms = 0;  // one linearisation: the first ("reduced") or the mean ("ceres")
  double solve_ms = 0;      // everything except setup
};

// Returns which of the 11 calibration parameters are fixed, in the order of CalibrationToBlock().
std::vector<bool> FixedCalibration(const RefinementOptions& options);

// Minimises the cost over poses and estimated calibration parameters with `options.solver`. The
// first pose is fixed. A failure leaves the state unchanged. The result is the same for any number
// of threads. `state` has one pose per keyframe. Throws InputError for an unknown solver.
JointReport MinimizeJointly(const JointProblem& problem, const RefinementOptions& options,
                            JointState* state);

// Solver "reduced": Levenberg-Marquardt over poses and calibration (Nielsen's damping rule). The
// surfel parameters are at their optimum in each step.
JointReport MinimizeReduced(const JointProblem& problem, const RefinementOptions& options,
                            JointState* state);

// Solver "ceres": a ceres::Problem over poses, calibration and surfel parameters, with autodiff
// residuals. `options.linear_solver` solves the Schur complement of the surfels. Runs on one
// thread: with more threads, Ceres sums costs and gradients in a varying order.
JointReport MinimizeWithCeres(const JointProblem& problem, const RefinementOptions& options,
                              JointState* state);

}  // namespace surfit
