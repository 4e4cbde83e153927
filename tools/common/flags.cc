#include "common/flags.h"

#include <gflags/gflags.h>

#include <map>

#include "surfit/core/error.h"
#include "surfit/io/camera_files.h"

namespace surfit::tools {
namespace {

using FlagValue = std::variant<bool, std::int32_t, std::uint64_t, double, std::string>;

// Calls a function for each option that has a flag.
class FlagVisitor final : public OptionVisitor {
 public:
  using Function = std::function<void(const Option&, const OptionValue&)>;
  explicit FlagVisitor(Function function) : function_(std::move(function)) {}

 private:
  void Visit(const Option& option, const OptionValue& value) override {
    if (!option.flag.empty()) function_(option, value);
  }

  Function function_;
};

void ForEachFlag(const OptionTable& table, const FlagVisitor::Function& function) {
  FlagVisitor visitor(function);
  table(visitor);
}

FlagValue ValueOf(const Option& option, const OptionValue& value) {
  return std::visit(
      [&](const auto* field) -> FlagValue {
        using T = std::decay_t<decltype(*field)>;
        if constexpr (std::is_same_v<T, OptionText>) {
          return field->Get();
        } else if constexpr (std::is_floating_point_v<T>) {
          return *field / option.FlagUnit();
        } else {
          return *field;
        }
      },
      value);
}

void SetValue(const Option& option, const FlagValue& flag, const OptionValue& value) {
  std::visit(
      [&](auto* field) {
        using T = std::decay_t<decltype(*field)>;
        if constexpr (std::is_same_v<T, OptionText>) {
          SetText("--" + option.flag, std::get<std::string>(flag), field);
        } else if constexpr (std::is_floating_point_v<T>) {
          *field = static_cast<T>(std::get<double>(flag) * option.FlagUnit());
        } else {
          *field = std::get<T>(flag);
        }
      },
      value);
}

// gflags stores only the last value of a flag, but passes each value to the validator.
std::map<std::string, std::vector<std::string>>& AllValues() {
  static std::map<std::string, std::vector<std::string>> values;
  return values;
}

bool AppendValue(const char* flag, const std::string& value) {
  if (!value.empty()) AllValues()[flag].push_back(value);
  return true;
}

bool IsSet(const std::string& flag) {
  return !gflags::GetCommandLineFlagInfoOrDie(flag.c_str()).is_default;
}

}  // namespace

std::vector<FlagHelp> Describe(const OptionTable& table) {
  std::vector<FlagHelp> flags;
  ForEachFlag(table, [&](const Option& option, const OptionValue& value) {
    const bool is_switch = std::holds_alternative<bool*>(value);
    flags.push_back({option.flag,
                     FlagText(option, value),
                     option.Help(),
                     option.group,
                     option.everyday,
                     is_switch,
                     option.flag == "camera" ? CameraPresetNames() : option.choices,
                     {}});
  });
  return flags;
}

bool HasFlag(const OptionTable& table, const std::string& flag) {
  bool found = false;
  ForEachFlag(table, [&](const Option& option, const OptionValue&) {
    found = found || option.flag == flag;
  });
  return found;
}

Flags::Flags(OptionTable table) : table_(std::move(table)) {
  ForEachFlag(table_, [&](const Option& option, const OptionValue& value) {
    const FlagValue now = ValueOf(option, value);
    const auto entry = storage_.emplace(option.flag, Storage{option.Help(), now, now}).first;
    const std::string& name = entry->first;
    Storage& flag = entry->second;
    std::visit(
        [&](auto& current) {
          using T = std::decay_t<decltype(current)>;
          gflags::FlagRegisterer(name.c_str(), flag.help.c_str(), "", &current,
                                 &std::get<T>(flag.default_value));
          if constexpr (std::is_same_v<T, std::string>) {
            if (option.repeatable) gflags::RegisterFlagValidator(&current, &AppendValue);
          }
        },
        flag.value);
  });
}

void Flags::Apply() const {
  ForEachFlag(table_, [&](const Option& option, const OptionValue& value) {
    if (!IsSet(option.flag)) return;
    if (option.repeatable) {
      auto* names = std::get<OptionText*>(value)->field();
      *static_cast<std::vector<std::string>*>(names) = AllValues()[option.flag];
    } else {
      SetValue(option, storage_.at(option.flag).value, value);
    }
  });
}

void Flags::Check() const {
  ForEachFlag(table_, [](const Option& option, const OptionValue& value) {
    RequireOption("--" + option.flag, option, value, /*in_degrees=*/true);
  });
}

}  // namespace surfit::tools
