#pragma once

#include <functional>
#include <string>

namespace surfit::tools {

// The exit codes of every program.
enum ExitCode { kDone = 0, kBadInput = 1, kAlgorithmFailed = 2 };

// Parses gflags (--flagfile and --help included), runs the program and turns exceptions into
// messages: InputError and bad flags print "error: ..." on stderr and give kBadInput, as does any
// other exception. --help prints the summary and our own flags with their defaults, on stdout.
int ToolMain(int argc, char** argv, const std::string& summary, const std::function<int()>& run);

// Throws InputError naming the flag if its value is empty.
void RequireFlag(const std::string& name, const std::string& value);

}  // namespace surfit::tools
