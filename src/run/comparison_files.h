#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "surfit/run/compare_solvers.h"

namespace surfit {

// A row as an element of `rows` in comparison.json.
nlohmann::ordered_json ToJson(const ComparisonRow& row);

// comparison.csv and comparison.json: a line, or an element of `rows`, for each row; slam.csv and
// `slam` likewise, where SLAM ran. What does not apply is empty, or null. Throws InputError naming
// the file that cannot be written.
void WriteComparisonFiles(const Comparison& comparison, const std::string& folder);

}  // namespace surfit
