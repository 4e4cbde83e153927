#pragma once

#include <string>

#include "apps/solvers/refine_run.h"
#include "apps/solvers/register_run.h"

namespace surfit {

// Writes refinement.json: result, errors and calibration before and after, standard deviations,
// rounds and options. Unknown values are null. Throws InputError with the name of the file.
void WriteRefinementJson(const RefineRunSummary& summary, const RefineRunOptions& options,
                         const std::string& path);

// Writes the result of a registration as JSON. Throws InputError with the name of the file.
void WriteRegistrationJson(const RegisterRunResult& result, const RegisterRunOptions& options,
                           const std::string& path);

}  // namespace surfit
