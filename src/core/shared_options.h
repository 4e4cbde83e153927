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

OptionRule InField(const std::string& field);  // the field has another name than the flag

}  // namespace surfit
