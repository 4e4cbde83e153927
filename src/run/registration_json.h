#pragma once

#include <string>

#include "surfit/run/register_run.h"

namespace surfit {

// Writes what came of a registration as JSON. Throws InputError naming the file.
void WriteRegistrationJson(const RegisterRunResult& result, const RegisterRunOptions& options,
                           const std::string& path);

}  // namespace surfit
