#pragma once

#include "surfit/registration/icp.h"
#include "surfit/registration/pose_solver.h"

namespace surfit {

// One resolution of a registration.
struct IcpLevel {
  const Association& association;
  const PoseSolver& solver;
  int level = 0;
  Rigid3d start;        // of the whole registration
  double focal_px = 0;  // turns a step into pixels, for min_coarse_step_px; 0 = not an image
};

// The options of a level's solver. Directions are free for it only where the eigenvalue is nothing
// but rounding: before convergence pairs are few, and normals differ by more than noise. With the
// pairs of a pose that is not yet the last, solves need not be finer than what ends a level.
PoseSolverOptions SolverOptions(const IcpOptions& options, const ErrorModel& error_model);

// Iterates from result->target_from_source until one of the terminations holds. On the finest level
// it then takes back what has moved, since the start, along directions that the data leaves free,
// and iterates along the others.
void RunLevel(const IcpLevel& level, const IcpOptions& options, IcpResult* result);

}  // namespace surfit
