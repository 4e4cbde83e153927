#pragma once

#include <string>

#include "surfit/run/refine_run.h"

namespace surfit {

// Writes refinement.json: outcome, errors before and after, calibration before and after with
// standard deviations, rounds, options; null for what is not known. Throws InputError naming the
// file if it cannot be written.
void WriteRefinementJson(const RefineRunSummary& summary, const RefineRunOptions& options,
                         const std::string& path);

}  // namespace surfit
