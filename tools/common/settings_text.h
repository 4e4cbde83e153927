#pragma once

#include <functional>
#include <map>
#include <string>

#include "surfit/core/options.h"

namespace surfit::tools {

// Options of a table as one text, name=value;name=value. A setting is an option with a flag, and
// has the name and the unit of this flag. Other options of the table keep their default values.
class SettingsText final : public OptionText {
 public:
  template <typename Options>
  explicit SettingsText(Options* options)
      : field_(options),
        type_(&typeid(Options)),
        table_(TableOf(options)),
        reset_([options] { *options = Options(); }) {
    Options defaults;
    defaults_ = TableFlags(TableOf(&defaults));
  }

  // Settings that differ from their default values, sorted by name.
  std::string Get() const override;
  // Settings without a value in the text get their default values. Throws InputError with the
  // setting, its value and the constraint for an unknown or repeated name and an invalid value.
  // Constraints between the options are checked, too.
  void Set(const std::string& text) override;
  const std::type_info& type() const override { return *type_; }
  void* field() override { return field_; }

 private:
  void* field_;
  const std::type_info* type_;
  OptionTable table_;
  std::function<void()> reset_;
  std::map<std::string, std::string> defaults_;  // by name
};

// Two numbers of options as one text, FIRST,SECOND. The text FIRST does not change the second
// number. The rules of both options apply.
class PairText final : public OptionText {
 public:
  PairText(Option first, OptionValue first_value, Option second, OptionValue second_value);

  std::string Get() const override;
  void Set(const std::string& text) override;
  const std::type_info& type() const override { return typeid(PairText); }
  void* field() override { return this; }

 private:
  Option first_, second_;
  OptionValue first_value_, second_value_;
};

// Help on the settings of a table, one line per setting, as "\nname=default: help".
std::string SettingsHelp(const OptionTable& table);

}  // namespace surfit::tools
