#pragma once

#include <array>

#include "optimization/refinement/joint_solver.h"
#include "optimization/refinement/shared_surfels.h"
#include "surfit/geometry/inverse_depth_field.h"
#include "surfit/optimization/refine.h"

namespace surfit {

// Decrease of the squared residuals of the first and the last half of the keyframes, in units of
// their variance. Compares an estimated with the input calibration. Poses and surfels are optimal
// in both cases. 0 for a half without redundant observations.
struct HalfGains {
  std::array<double, 2> own = {0, 0};       // with the calibration of all keyframes
  std::array<double, 2> held_out = {0, 0};  // with the calibration of the other half
};

// Cross-validates a calibration. An error of the model differs from place to place, for example
// depth that a filter has bent. The calibration that it causes does not fit to other keyframes.
//
// At the state `found`, the cost of a half is a quadratic function of the calibration c:
//   q_h(c) = g_h . (c - c_found) + (c - c_found) . H_h (c - c_found) / 2.
// The other half and the prior have their minimum at c_h. The gains are
//   2 (q_h(given) - q_h(c_found)) / variance_h and 2 (q_h(given) - q_h(c_h)) / variance_h.
// `shared`: surfels at the state `found`. Uses plane residuals only. Costs about one linearisation.
HalfGains GainsOf(const SharedSurfels& shared, const JointState& found,
                  const DepthCalibration& given, const JointPrior& prior,
                  const RefinementOptions& options);

}  // namespace surfit
