#include "common/settings_text.h"

#include <charconv>
#include <set>
#include <sstream>

#include "core/named_values.h"
#include "surfit/core/error.h"

namespace surfit::tools {
namespace {

std::string WithoutSpaces(const std::string& text) {
  const std::size_t first = text.find_first_not_of(' ');
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(' ') + 1 - first);
}

template <typename Number>
Number NumberFromSetting(const std::string& name, const std::string& text) {
  Number number = 0;
  const char* const end = text.data() + text.size();
  const auto [read, error] = std::from_chars(text.data(), end, number);
  ThrowIf(error != std::errc() || read != end, name, " is '", text, "', must be a ",
          std::is_integral_v<Number> ? "whole " : "", "number");
  return number;
}

// Sets an option to the value of a text. Throws InputError with `name` and the constraint.
void SetToText(const std::string& name, const Option& option, const std::string& text,
               const OptionValue& value) {
  std::visit(
      [&](auto* field) {
        using T = std::decay_t<decltype(*field)>;
        if constexpr (std::is_same_v<T, OptionText>) {
          SetText(name, text, field);
        } else if constexpr (std::is_same_v<T, std::string>) {
          *field = text;
        } else if constexpr (std::is_same_v<T, bool>) {
          ThrowIf(text != "true" && text != "false", name, " is '", text,
                  "', must be true or false");
          *field = text == "true";
        } else if constexpr (std::is_floating_point_v<T>) {
          *field = static_cast<T>(NumberFromSetting<T>(name, text) * option.FlagUnit());
        } else {
          *field = NumberFromSetting<T>(name, text);
        }
      },
      value);
  RequireOption(name, option, value, /*in_degrees=*/true);
}

// Sets the setting with a name to the value of a text.
class SettingSetter final : public OptionVisitor {
 public:
  SettingSetter(std::string name, std::string text)
      : name_(std::move(name)), text_(std::move(text)) {}

 private:
  void Visit(const Option& option, const OptionValue& value) override {
    if (option.flag == name_) SetToText(name_, option, text_, value);
  }

  std::string name_, text_;
};

class SettingsHelper final : public OptionVisitor {
 public:
  std::string text;

 private:
  void Visit(const Option& option, const OptionValue& value) override {
    if (option.flag.empty()) return;
    const std::string now = FlagText(option, value);
    text += "\n" + option.flag + (now.empty() ? "" : "=" + now) + ": " + option.Help();
  }
};

}  // namespace

std::string SettingsText::Get() const {
  std::string text;
  for (const auto& [name, value] : TableFlags(table_)) {
    if (value != defaults_.at(name)) text += Concat(text.empty() ? "" : ";", name, "=", value);
  }
  return text;
}

void SettingsText::Set(const std::string& text) {
  reset_();
  std::set<std::string> names;
  std::istringstream settings(text);
  for (std::string setting; std::getline(settings, setting, ';');) {
    setting = WithoutSpaces(setting);
    if (setting.empty()) continue;
    const std::size_t equals = setting.find('=');
    ThrowIf(equals == std::string::npos, "name=value;name=value, but '", setting, "' has no =");
    const std::string name = WithoutSpaces(setting.substr(0, equals));
    if (defaults_.count(name) == 0) {
      std::vector<std::string> known;
      for (const auto& [known_name, value] : defaults_) known.push_back(known_name);
      throw InputError("valid settings: the name '", name, "' must be one of: ", JoinNames(known));
    }
    ThrowIf(!names.insert(name).second, "valid settings: ", name, " is set twice");
    SettingSetter setter(name, WithoutSpaces(setting.substr(equals + 1)));
    WithContext("valid settings", [&] { table_(setter); });
  }
  WithContext("valid settings", [&] { ValidateTable(table_); });
}

PairText::PairText(Option first, OptionValue first_value, Option second, OptionValue second_value)
    : first_(std::move(first)),
      second_(std::move(second)),
      first_value_(first_value),
      second_value_(second_value) {}

std::string PairText::Get() const {
  return FlagText(first_, first_value_) + "," + FlagText(second_, second_value_);
}

void PairText::Set(const std::string& text) {
  const std::size_t comma = text.find(',');
  const std::string form = first_.name + "," + second_.name;
  WithContext(form, [&] {
    SetToText(first_.name, first_, text.substr(0, comma), first_value_);
    if (comma == std::string::npos) return;
    SetToText(second_.name, second_, text.substr(comma + 1), second_value_);
  });
}

std::string SettingsHelp(const OptionTable& table) {
  SettingsHelper helper;
  table(helper);
  return std::move(helper.text);
}

}  // namespace surfit::tools
