#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <variant>
#include <vector>

#include "surfit/core/options.h"

namespace surfit::tools {

// Description of a flag for help texts.
struct FlagHelp {
  std::string name, default_value, help, group;
  bool everyday = false;
  bool is_switch = false;            // --name or --noname
  std::vector<std::string> choices;  // possible values, or usual values
  std::vector<std::string> modes;    // modes with this flag; empty: all
};

// Help on the everyday flags, or on all flags if these are few, with a hint on the help for `all`.
std::string EverydayHelp(const std::vector<FlagHelp>& flags, const std::vector<FlagHelp>& all);
// Help on all flags, by group.
std::string FullHelp(const std::vector<FlagHelp>& flags);
// Help on a group of flags. Throws InputError with a list of the groups for an unknown group.
std::string GroupHelp(const std::vector<FlagHelp>& flags, const std::string& group);

// Words for shell completion, one per line: --name= for a flag, --name and --noname for a switch,
// and --name=value for each choice.
std::string CompletionWords(const std::vector<FlagHelp>& flags);

// Help of the flags of a table. Default values are the present values of the options. `modes` is
// empty.
std::vector<FlagHelp> Describe(const OptionTable& table);

// True if a field of the table has this flag.
bool HasFlag(const OptionTable& table, const std::string& flag);

// Flags of a program, from its table of options. Default values are the values of the options at
// construction. Registers the flags with gflags, which keeps pointers: this object must live until
// the program ends. Order of calls: constructor, ParseCommandLine(), Apply(), Check().
class Flags {
 public:
  explicit Flags(OptionTable table);
  Flags(const Flags&) = delete;

  // Sets the options whose flags are set. Other options keep their values. Throws InputError for a
  // text that the option does not accept.
  void Apply() const;
  // Throws InputError with the name of the first flag with an invalid value. Constraints between
  // fields are not checked.
  void Check() const;

 private:
  struct Storage {
    std::string help;
    std::variant<bool, std::int32_t, std::uint64_t, double, std::string> value, default_value;
  };

  OptionTable table_;
  std::map<std::string, Storage> storage_;  // by name; gflags has pointers to the values
};

}  // namespace surfit::tools
