#pragma once

#include "surfit/registration/icp.h"

namespace surfit::tools {

// The flags of registration that hold for clouds and for frames, shared by all programs that
// register. What has no flag is taken from `base`, and so are solver, residual and association
// (solver_flags.h).
IcpOptions IcpOptionsFromFlags(const IcpOptions& base);

// Makes these the flags' defaults, for a program whose own differ. To be called before ToolMain().
void SetIcpFlagDefaults(const IcpOptions& options);

}  // namespace surfit::tools
