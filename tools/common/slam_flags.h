#pragma once

#include "common/icp_flags.h"
#include "surfit/slam/slam.h"

namespace surfit::tools {

// The flags of preprocessing and registration, shared by all programs that register frames.
PreprocessOptions PreprocessOptionsFromFlags();
// What has no flag is taken from `base`, and so are solver, residual and association
// (solver_flags.h).
IcpOptions FrameIcpOptionsFromFlags(const IcpOptions& base = {});

}  // namespace surfit::tools
