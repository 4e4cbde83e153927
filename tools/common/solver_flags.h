#pragma once

#include "surfit/registration/icp.h"

namespace surfit::tools {

// Solver, residual and association, for programs that register in one way.
void SetSolverFromFlags(IcpOptions* options);

}  // namespace surfit::tools
