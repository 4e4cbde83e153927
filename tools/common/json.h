#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "surfit/core/options.h"
#include "surfit/evaluation/error_statistics.h"

namespace surfit::tools {

// Keys keep the order in which they are set.
using Json = nlohmann::ordered_json;

// Sets the keys `prefix`_rmse_`unit`, and the same with mean, median, p90 and max. Values are null
// without statistics.
void SetStatistics(const std::string& prefix, const std::string& unit,
                   const ErrorStatistics* statistics, Json* json);

// Values of all flags by name, as numbers, booleans or texts.
Json FlagsToJson(const OptionTable& options);

// Text of a JSON file: indented, with a line feed at the end. Invalid UTF-8, e.g. in file names, is
// replaced.
std::string ToText(const Json& json);

// Prints JSON on stdout. Throws InputError if stdout cannot be written.
void PrintJson(const Json& json);

}  // namespace surfit::tools
