#include "common/modes.h"

#include <algorithm>
#include <utility>

#include "surfit/core/error.h"

namespace surfit::tools {
namespace {

// The last value of a flag on the command line; std::nullopt if it is not set.
std::optional<std::string> LastValue(const std::string& flag,
                                     const std::vector<std::string>& arguments) {
  std::optional<std::string> value;
  for (std::size_t i = 1; i < arguments.size(); ++i) {
    for (const std::string& name : {"--" + flag, "-" + flag}) {
      const std::string& argument = arguments[i];
      if (argument.rfind(name + "=", 0) == 0) value = argument.substr(name.size() + 1);
      if (argument == name && i + 1 < arguments.size()) value = arguments[i + 1];
    }
  }
  return value;
}

FlagHelp* Find(const std::string& name, std::vector<FlagHelp>* flags) {
  for (FlagHelp& flag : *flags) {
    if (flag.name == name) return &flag;
  }
  return nullptr;
}

}  // namespace

Modes::Modes(const ModeFlag& flag, std::vector<Mode> modes,
             const std::vector<std::string>& arguments)
    : flag_(flag), modes_(std::move(modes)), name_(modes_.front().name) {
  if (flag.name.empty()) return;
  std::vector<std::string> names;
  for (const Mode& mode : modes_) names.push_back(mode.name);
  const Option option(flag.name, flag.help, OneOf(names), Everyday());
  given_ = LastValue(flag.name, arguments);
  if (given_) name_ = *given_;
  RequireOption("--" + flag.name, option, &name_);
  selected_ = std::find(names.begin(), names.end(), name_) - names.begin();
  for (Mode& mode : modes_) {
    mode.options = [this, option, own = mode.options](OptionVisitor& v) {
      v.Group("");
      v.Add(name_, option);
      own(v);
    };
  }
}

std::vector<FlagHelp> Modes::Described() const {
  if (given_ || modes_.size() == 1) return Describe(selected().options);
  std::vector<FlagHelp> all;
  for (const Mode& mode : modes_) {
    for (FlagHelp flag : Describe(mode.options)) {
      FlagHelp* const known = Find(flag.name, &all);
      if (known == nullptr) {
        flag.modes = {mode.name};
        all.push_back(flag);
      } else if (known->default_value == flag.default_value) {
        known->modes.push_back(mode.name);
      } else {
        known->modes.push_back(mode.name + "=" + flag.default_value);
      }
    }
  }
  for (FlagHelp& flag : all) {
    if (flag.name == flag_.name) flag.modes.clear();
  }
  return all;
}

std::string Modes::ModesOf(const std::string& flag) const {
  std::string names;
  for (const Mode& mode : modes_) {
    if (HasFlag(mode.options, flag)) names += (names.empty() ? "" : " or ") + mode.name;
  }
  if (names.empty()) return "";
  return Concat("--", flag, " does not belong to --", flag_.name, "=", selected().name,
                " but to --", flag_.name, "=", names);
}

}  // namespace surfit::tools
