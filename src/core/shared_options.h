#pragma once

#include <string>

#include "surfit/core/options.h"

namespace surfit {

// Declaration of a flag that several tables share, with one help text and one set of bounds.
// Defaults may differ. Throws InputError for an unknown flag.
Option SharedOption(const std::string& flag);

// Declaration with additional rules for one table.
template <typename... Rules>
Option SharedOption(const std::string& flag, const Rules&... rules) {
  Option option = SharedOption(flag);
  (rules(option), ...);
  return option;
}

// The present name of an option, a flag or a Python attribute that has another name in version 0.1.
// Returns other names unchanged. Version 0.3 drops the old names.
std::string PresentName(const std::string& name);
// The name in version 0.1 of an option with this present name. Returns other names unchanged.
std::string OldName(const std::string& name);

OptionRule InField(const std::string& field);  // name of the field, if it differs from the flag

}  // namespace surfit
