#pragma once

#include "surfit/registration/icp.h"
#include "surfit/registration/pose_solver.h"

namespace surfit {

// One resolution of a registration.
struct IcpLevel {
  const Association& association;
  const PoseSolver& solver;
  int level = 0;
  double focal_px = 0;  // turns a step into pixels, for min_coarse_step_px; 0 = not an image
};

// Iterates from result->target_from_source until one of the terminations holds.
void RunLevel(const IcpLevel& level, const IcpOptions& options, IcpResult* result);

}  // namespace surfit
