#include "core/settings_text.h"

#include <charconv>
#include <set>
#include <sstream>

#include "core/named_values.h"
#include "surfit/core/error.h"

namespace surfit {
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

// Sets the setting with a name to the value of a text.
class SettingSetter final : public OptionVisitor {
 public:
  SettingSetter(std::string name, std::string text)
      : name_(std::move(name)), text_(std::move(text)) {}

 private:
  void Visit(const Option& option, const OptionValue& value) override {
    if (option.flag != name_) return;
    std::visit([&](auto* field) { SetField(option, field); }, value);
    RequireOption(name_, option, value, /*in_degrees=*/true);
  }

  template <typename T>
  void SetField(const Option& option, T* field) const {
    if constexpr (std::is_same_v<T, OptionText>) {
      SetText(name_, text_, field);
    } else if constexpr (std::is_same_v<T, std::string>) {
      *field = text_;
    } else if constexpr (std::is_same_v<T, bool>) {
      ThrowIf(text_ != "true" && text_ != "false", name_, " is '", text_,
              "', must be true or false");
      *field = text_ == "true";
    } else if constexpr (std::is_floating_point_v<T>) {
      *field = static_cast<T>(NumberFromSetting<T>(name_, text_) * option.FlagUnit());
    } else {
      *field = NumberFromSetting<T>(name_, text_);
    }
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
    if (value != defaults_.at(name)) text += (text.empty() ? "" : ";") + name + "=" + value;
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

std::string SettingsHelp(const OptionTable& table) {
  SettingsHelper helper;
  table(helper);
  return std::move(helper.text);
}

}  // namespace surfit
