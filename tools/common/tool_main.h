#pragma once

#include <functional>
#include <string>

#include "surfit/core/options.h"

namespace surfit::tools {

// The exit codes of every program.
enum ExitCode { kDone = 0, kBadInput = 1, kAlgorithmFailed = 2, kFaultsFound = 3 };

// Runs a program. Its flags are those of the table of its options, whose values are the defaults.
// What the user has set goes into the options before prepare(), which may change them by what it
// finds there, and once more after it: a flag that is given wins. Then values are checked, and
// run() gives the exit code. InputError, bad flags and any other exception print "error: ..." on
// stderr and give kBadInput, and so does an output that is one of the inputs. -h, --help,
// --help=all,
// --help=GROUP and --version print on stdout.
int ToolMain(int argc, char** argv, const std::string& summary, const OptionTable& options,
             const std::function<int()>& run, const std::function<void()>& prepare = {});

// The same for options that need no preparation.
template <typename Options>
int ToolMain(int argc, char** argv, const std::string& summary, int (*run)(const Options&)) {
  Options options;
  return ToolMain(argc, argv, summary, TableOf(&options), [&] { return run(options); });
}

// Throws InputError naming the flag if its value is empty.
void RequireFlag(const std::string& name, const std::string& value);

}  // namespace surfit::tools
