#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <variant>
#include <vector>

#include "surfit/core/options.h"

namespace surfit::tools {

// What help says of one flag.
struct FlagHelp {
  std::string name, default_value, help, group;
  bool everyday = false;
  bool is_switch = false;            // --name or --noname
  std::vector<std::string> choices;  // what it may be, or usually is
  std::vector<std::string> modes;    // modes of the program that have it; empty: all
};

// The everyday flags, or all flags if these are few, and how to see the flags of `all` beside them.
std::string EverydayHelp(const std::vector<FlagHelp>& flags, const std::vector<FlagHelp>& all);
// All flags, group by group.
std::string FullHelp(const std::vector<FlagHelp>& flags);
// Throws InputError that lists the groups if there is no such one.
std::string GroupHelp(const std::vector<FlagHelp>& flags, const std::string& group);

// What completes a command line, one a line: --name= of each flag, --name and --noname of a switch,
// and --name=value for each of the choices.
std::string CompletionWords(const std::vector<FlagHelp>& flags);

// Help of the flags of a table, with the present values of the options as defaults.
std::vector<FlagHelp> Describe(const OptionTable& table);

// Whether one of the options has such a flag.
bool HasFlag(const OptionTable& table, const std::string& flag);

// The flags of a program: those that its table of options names. Their defaults are the values that
// the options have when the flags are made.
class Flags {
 public:
  // Registers them with gflags.
  explicit Flags(OptionTable table);
  Flags(const Flags&) = delete;

  // Gives the options the values of the flags that are set, and leaves the others alone.
  void Apply() const;
  // Throws InputError naming the first flag whose option has a value that it must not have.
  void Check() const;

 private:
  struct Storage {
    std::string help;
    std::variant<bool, std::int32_t, std::uint64_t, double, std::string> value, default_value;
  };

  OptionTable table_;
  std::map<std::string, Storage> storage_;  // by name; gflags keeps pointers
};

}  // namespace surfit::tools
