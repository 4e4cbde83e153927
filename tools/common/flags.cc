#include "common/flags.h"

#include <gflags/gflags.h>

#include <fstream>
#include <map>
#include <optional>
#include <sstream>

#include "surfit/core/error.h"

namespace surfit::tools {
namespace {

bool IsFlagFileFlag(const std::string& argument) {
  return argument == "--flagfile" || argument == "-flagfile";
}

// The file of --flagfile=F.
std::optional<std::string> FlagFileOf(const std::string& argument) {
  const std::size_t equals = argument.find('=');
  if (equals == argument.npos || !IsFlagFileFlag(argument.substr(0, equals))) return std::nullopt;
  return argument.substr(equals + 1);
}

std::string Trimmed(const std::string& line) {
  constexpr const char* kSpace = " \t\r";
  const std::size_t first = line.find_first_not_of(kSpace);
  if (first == line.npos) return "";
  return line.substr(first, line.find_last_not_of(kSpace) + 1 - first);
}

void AppendLines(const std::string& path, std::vector<std::string>* arguments) {
  constexpr std::streamsize kMost = 1 << 20;  // bytes
  std::ifstream file(path);
  std::string text(kMost, '\0');
  file.read(text.data(), kMost);
  if (!file.eof())
    throw InputError(Concat("flagfile '", path, "' cannot be read, or is too large"));
  text.resize(static_cast<std::size_t>(file.gcount()));
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const std::string flag = Trimmed(line);
    if (flag.empty() || flag[0] == '#') continue;
    if (IsFlagFileFlag(flag) || FlagFileOf(flag)) {
      throw InputError(Concat("flagfile '", path, "' says ", flag, ", must not name another one"));
    }
    arguments->push_back(flag);
  }
}

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

// gflags keeps a flag's last value only, but shows each one to its validator.
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

std::vector<std::string> ExpandFlagFiles(const std::vector<std::string>& arguments) {
  std::vector<std::string> expanded;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const bool next_is_file = IsFlagFileFlag(arguments[i]) && i + 1 < arguments.size();
    const auto path = next_is_file ? arguments[++i] : FlagFileOf(arguments[i]);
    if (path) {
      AppendLines(*path, &expanded);
    } else {
      expanded.push_back(arguments[i]);
    }
  }
  return expanded;
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

std::vector<FlagHelp> Flags::Described() const {
  std::vector<FlagHelp> flags;
  ForEachFlag(table_, [&](const Option& option, const OptionValue& value) {
    flags.push_back(
        {option.flag, FlagText(option, value), option.Help(), option.group, option.everyday});
  });
  return flags;
}

}  // namespace surfit::tools
