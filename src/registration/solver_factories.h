#pragma once

#include <memory>

#include "surfit/registration/pose_solver.h"

namespace surfit {

// Null for names that are not theirs.
std::unique_ptr<PoseSolver> MakeClosedFormSolver(const PoseSolverOptions& options);
std::unique_ptr<PoseSolver> MakeSvdSolver(const PoseSolverOptions& options);
std::unique_ptr<PoseSolver> MakeCeresSolver(const PoseSolverOptions& options);
std::unique_ptr<PoseSolver> MakeTinySolver(const PoseSolverOptions& options);

}  // namespace surfit
