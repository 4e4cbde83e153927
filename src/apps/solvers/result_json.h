#pragma once

#include <string>

#include "apps/solvers/refine_run.h"
#include "apps/solvers/register_run.h"

namespace surfit {

// Unknown values are null. All functions throw InputError with the file name if writing fails.
void WriteRefinementJson(const RefineRunSummary& summary, const RefineRunOptions& options,
                         const std::string& path);

void WriteRegistrationJson(const RegisterRunResult& result, const RegisterRunOptions& options,
                           const std::string& path);

void WriteAlignmentJson(const AlignRunResult& result, const AlignRunOptions& options,
                        const std::string& path);

}  // namespace surfit
