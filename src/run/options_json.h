#pragma once

#include <nlohmann/json.hpp>

#include "surfit/frame/preprocess.h"
#include "surfit/registration/icp.h"

namespace surfit {

// All fields by name, numbers without loss. Reading throws nlohmann's exceptions for a missing
// field or one of another type, and InputError for unknown names.
nlohmann::ordered_json ToJson(const IcpOptions& options);
nlohmann::ordered_json ToJson(const PreprocessOptions& options);
IcpOptions IcpOptionsFromJson(const nlohmann::ordered_json& json);
PreprocessOptions PreprocessOptionsFromJson(const nlohmann::ordered_json& json);

}  // namespace surfit
