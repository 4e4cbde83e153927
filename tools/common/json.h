#pragma once

#include <nlohmann/json.hpp>

#include "surfit/evaluation/error_statistics.h"

namespace surfit::tools {

// Keys stay in the order in which they are set.
using Json = nlohmann::ordered_json;

// Sets `prefix`_rmse_`unit`, and so on for mean, median, p90 and max; null without statistics.
void SetStatistics(const std::string& prefix, const std::string& unit,
                   const ErrorStatistics* statistics, Json* json);

}  // namespace surfit::tools
