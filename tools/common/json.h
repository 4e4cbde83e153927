#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "surfit/core/options.h"
#include "surfit/evaluation/error_statistics.h"

namespace surfit::tools {

// Keys stay in the order in which they are set.
using Json = nlohmann::ordered_json;

// Sets `prefix`_rmse_`unit`, and so on for mean, median, p90 and max; null without statistics.
void SetStatistics(const std::string& prefix, const std::string& unit,
                   const ErrorStatistics* statistics, Json* json);

// All flags of a table with their values.
Json FlagsToJson(const OptionTable& options);

// The text of a JSON file: indented, a line feed at the end; what is no UTF-8 (a file's name may
// be anything) is replaced.
std::string ToText(const Json& json);

// Prints it on stdout. Throws InputError if stdout cannot take it.
void PrintJson(const Json& json);

}  // namespace surfit::tools
