#pragma once

#include <string>

#include "surfit/core/options.h"

namespace surfit {

// Flag that several tables share, with one help text and one set of bounds. Defaults may differ.
// Throws InputError for an unknown flag.
Option SharedOption(const std::string& flag);

// `rules` are applied after the rules of the shared flag.
template <typename... Rules>
Option SharedOption(const std::string& flag, const Rules&... rules) {
  Option option = SharedOption(flag);
  (rules(option), ...);
  return option;
}

// Present name of an option, flag or Python attribute of version 0.1. Returns other names
// unchanged. Version 0.3 drops the old names.
std::string PresentName(const std::string& name);
// Name in version 0.1 of an option. Returns other names unchanged.
std::string OldName(const std::string& name);

OptionRule InField(const std::string& field);  // field name, if it differs from the flag

// Values of all options, to save them with results: by their flags, and by the paths of their
// fields without a flag, for example slam.fusion.duplicate_ratio.
std::map<std::string, std::string> RecordedValues(const OptionTable& table);

}  // namespace surfit
