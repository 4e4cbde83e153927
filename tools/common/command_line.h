#pragma once

#include <string>
#include <vector>

#include "common/flags.h"

namespace surfit::tools {

// The arguments with each --flagfile=F (or --flagfile F) replaced by the lines of F, one flag a
// line, without empty lines and # comments. gflags' own reader passes over flags that it does not
// know; as arguments they are refused, wherever they stand. Throws InputError naming a file that
// cannot be read, or that names another one.
std::vector<std::string> ExpandFlagFiles(const std::vector<std::string>& arguments);

// Gives gflags the program's arguments. -h is --help, --help=all is --helpfull and --help=GROUP is
// --helpon=GROUP. Throws InputError for a bad one: with the flag that was meant where one of those
// described has nearly the name.
void ParseCommandLine(int argc, char** argv, const std::vector<FlagHelp>& flags);

// What is asked for instead of a run: help, the version, or the words that complete a command line
// (--help=words: see CompletionWords()); an empty text if nothing is. Throws InputError that lists
// the groups if help on another one is asked for.
std::string AskedFor(const std::string& program, const std::string& summary,
                     const std::vector<FlagHelp>& flags);

}  // namespace surfit::tools
