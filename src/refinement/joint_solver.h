#pragma once

#include <vector>

#include "refinement/motion_prior.h"

namespace surfit {

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
int MinimizeJointly(const SharedSurfels& shared, const MotionPrior& prior,
                    const JointKernels& kernels, const RefinementOptions& options,
                    JointState* state);

}  // namespace surfit
