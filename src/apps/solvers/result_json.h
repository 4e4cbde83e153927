#pragma once

#include <string>

#include "apps/solvers/refine_run.h"
#include "apps/solvers/register_run.h"

namespace surfit {

// Unknown values are null. Throws InputError with the file name.
void WriteRefinementJson(const RefineRunSummary& summary, const RefineRunOptions& options,
                         const std::string& path);

// Throws InputError with the file name.
void WriteRegistrationJson(const RegisterRunResult& result, const RegisterRunOptions& options,
                           const std::string& path);

}  // namespace surfit
