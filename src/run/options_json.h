#pragma once

#include <nlohmann/json.hpp>

#include "surfit/core/options.h"

namespace surfit {

nlohmann::ordered_json TableToJson(const OptionTable& table);
void ReadTable(const nlohmann::ordered_json& json, const OptionTable& table);

// All fields by name, numbers without loss, parts as objects.
template <typename Options>
nlohmann::ordered_json OptionsToJson(Options options) {
  return TableToJson(TableOf(&options));
}

// Throws nlohmann's exceptions for a missing field or one of another type, and InputError for a
// text that does not fit.
template <typename Options>
Options OptionsFromJson(const nlohmann::ordered_json& json) {
  Options options;
  ReadTable(json, TableOf(&options));
  return options;
}

}  // namespace surfit
