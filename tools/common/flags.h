#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <variant>
#include <vector>

#include "common/flag_help.h"
#include "surfit/core/options.h"

namespace surfit::tools {

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

  // What help says of them, with the options' present values.
  std::vector<FlagHelp> Described() const;

 private:
  struct Storage {
    std::string help;
    std::variant<bool, std::int32_t, std::uint64_t, double, std::string> value, default_value;
  };

  OptionTable table_;
  std::map<std::string, Storage> storage_;  // by name; gflags keeps pointers
};

}  // namespace surfit::tools
