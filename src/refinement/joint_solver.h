#pragma once

#include <vector>

#include "refinement/motion_prior.h"

namespace surfit {

inline constexpr int kNoSolution = -1;

// Which of the calibration's ten numbers are not to change.
std::vector<bool> HeldCalibration(const RefinementOptions& options);

// Moves poses, but for the first, and the free calibration to the least cost, by Ceres'
// Levenberg-Marquardt, with the same observations throughout. Returns the number of steps, or
// kNoSolution, which leaves the state as it was.
int MinimizeJointly(const SharedSurfels& shared, const MotionPrior& prior,
                    const RobustKernel& kernel, const RefinementOptions& options,
                    JointState* state);

}  // namespace surfit
