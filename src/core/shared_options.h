#pragma once

#include <string>

#include "surfit/core/options.h"

namespace surfit {

// Declaration of a flag that several tables have: the flag has one text and one set of bounds. The
// defaults may differ.
Option SharedOption(const std::string& flag);

// Declaration with additional rules of one table.
template <typename... Rules>
Option SharedOption(const std::string& flag, const Rules&... rules) {
  Option option = SharedOption(flag);
  (rules(option), ...);
  return option;
}

// The present name of an option, a flag or a Python attribute that has another name in version 0.1.
// Returns other names unchanged. Version 0.3 drops the old names.
std::string PresentName(const std::string& name);

OptionRule InField(const std::string& field);  // the field has another name than the flag

}  // namespace surfit
