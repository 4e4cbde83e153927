#pragma once

#include <string>

#include "surfit/core/options.h"

namespace surfit::tools {

// Gives each flag of these options the value that a run's summary.json has recorded for it, unless
// the command line has set it. Throws InputError naming the file if it cannot be read or tells no
// such options, and the flag whose value does not fit.
void TakeRecordedFlags(const std::string& summary_json, const OptionTable& options);

}  // namespace surfit::tools
