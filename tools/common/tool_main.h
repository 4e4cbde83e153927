#pragma once

#include <string>
#include <vector>

#include "common/modes.h"

namespace surfit::tools {

// The exit codes of every program.
enum ExitCode { kDone = 0, kBadInput = 1, kAlgorithmFailed = 2, kFaultsFound = 3 };

// Runs a program. The flags are those of the option table of the selected mode, with the values of
// its options as defaults. Options that the user sets take precedence over `prepare` of the mode.
// Exceptions, bad flags and an output that is one of the inputs print "error: ..." on stderr and
// give kBadInput. -h, --help, --help=all, --help=GROUP and --version print on stdout.
int ToolMain(int argc, char** argv, const std::string& summary, const ModeFlag& flag,
             std::vector<Mode> modes);

// Runs a program with one mode.
template <typename Options>
int ToolMain(int argc, char** argv, const std::string& summary, int (*run)(const Options&),
             void (*prepare)(Options*) = nullptr) {
  return ToolMain(argc, argv, summary, ModeFlag(), {MakeMode("", run, prepare)});
}

// Throws InputError naming the flag if its value is empty.
void RequireFlag(const std::string& name, const std::string& value);

}  // namespace surfit::tools
