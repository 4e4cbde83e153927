#pragma once

#include <string>

#include "surfit/run/slam_run.h"

namespace surfit {

// Writes summary.json: what is known of the run, null where it is not. Throws InputError naming
// the file if it cannot be written.
void WriteSummaryJson(const SlamRunSummary& summary, const SlamRunOptions& options,
                      const std::string& path);

}  // namespace surfit
