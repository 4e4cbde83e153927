#pragma once

#include <string>
#include <vector>

#include "common/modes.h"

namespace surfit::tools {

// Exit codes of all programs.
enum ExitCode { kDone = 0, kBadInput = 1, kAlgorithmFailed = 2, kFaultsFound = 3 };

// Runs a program. Flags are defined by the option table of the selected mode. Default values are
// the values of its options. Flags of the user take precedence over `prepare` of the mode. Invalid
// flags, exceptions, an output that is also an input, and an incomplete stdout print "error: ..."
// on stderr and return kBadInput. -h, --help, --help=all, --help=GROUP and --version print on
// stdout.
int ToolMain(int argc, char** argv, const std::string& summary, const ModeFlag& flag,
             std::vector<Mode> modes);

template <typename Options>
int ToolMain(int argc, char** argv, const std::string& summary, int (*run)(const Options&),
             void (*prepare)(Options*) = nullptr) {
  return ToolMain(argc, argv, summary, ModeFlag(), {MakeMode("", run, prepare)});
}

// Throws InputError with the name of the flag if its value is empty.
void RequireFlag(const std::string& name, const std::string& value);

}  // namespace surfit::tools
