#pragma once

#include "surfit/run/refine_run.h"

namespace surfit::tools {

// Refines, says on stderr how far it is, and prints errors and calibration before and after.
// Returns the program's exit code.
int RefineAndPrint(const RefineRunOptions& options);

}  // namespace surfit::tools
