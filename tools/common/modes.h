#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/flags.h"
#include "surfit/core/options.h"

namespace surfit::tools {

// A task of a program with its own options.
struct Mode {
  std::string name;  // empty if the program has one task
  OptionTable options;
  std::function<int()> run;       // returns the exit code
  std::function<void()> prepare;  // sets options that depend on other options; may be empty
};

// Mode with default options, which the mode owns. `run` returns the exit code. `prepare` is called
// between parsing and running.
template <typename Options>
Mode MakeMode(const std::string& name, int (*run)(const Options&),
              void (*prepare)(Options*) = nullptr) {
  const auto options = std::make_shared<Options>();
  Mode mode = {
      name, [=](OptionVisitor& v) { options->Visit(v); }, [=] { return run(*options); }, {}};
  if (prepare != nullptr) mode.prepare = [=] { prepare(options.get()); };
  return mode;
}

// The flag that selects the mode. The name is empty if the program has one mode.
struct ModeFlag {
  std::string name, help;
};

// The modes of a program, at least one. The command line selects one of them. Default: the first
// mode. The option tables of the modes refer to this object.
class Modes {
 public:
  // Throws InputError if the flag has an unknown value.
  Modes(const ModeFlag& flag, std::vector<Mode> modes, const std::vector<std::string>& arguments);
  Modes(const Modes&) = delete;
  Modes& operator=(const Modes&) = delete;

  const Mode& selected() const { return modes_[selected_]; }

  // Flags for help: flags of the mode on the command line, or of all modes if none is given.
  std::vector<FlagHelp> Described() const;

  // Sentence that the flag belongs to other modes than the selected one, with their names. Empty if
  // no mode has the flag.
  std::string ModesOf(const std::string& flag) const;

 private:
  ModeFlag flag_;
  std::vector<Mode> modes_;
  std::optional<std::string> given_;
  std::string name_;
  std::size_t selected_ = 0;
};

}  // namespace surfit::tools
