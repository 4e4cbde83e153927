#pragma once

#include <string>

#include "apps/solvers/refine_run.h"
#include "apps/solvers/register_run.h"

namespace surfit {

// Writes refinement.json: outcome, errors before and after, calibration before and after with
// standard deviations, rounds, options; null for what is not known. Throws InputError naming the
// file if it cannot be written.
void WriteRefinementJson(const RefineRunSummary& summary, const RefineRunOptions& options,
                         const std::string& path);

// Writes what came of a registration as JSON. Throws InputError naming the file.
void WriteRegistrationJson(const RegisterRunResult& result, const RegisterRunOptions& options,
                           const std::string& path);

}  // namespace surfit
