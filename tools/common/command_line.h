#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/flags.h"

namespace surfit::tools {

// The arguments with each --flagfile=F (or --flagfile F) replaced by the lines of F, one flag a
// line, without empty lines and # comments. gflags' own reader passes over flags that it does not
// know; as arguments they are refused, wherever they stand. Throws InputError naming a file that
// cannot be read, or that names another one.
std::vector<std::string> ExpandFlagFiles(const std::vector<std::string>& arguments);

// The arguments with the present names of renamed flags. Logs a warning per renamed flag.
std::vector<std::string> WithPresentNames(std::vector<std::string> arguments);

// Explains why a program does not have a flag. Returns an empty text for unknown flags.
using UnknownFlag = std::function<std::string(const std::string& flag)>;

// Gives gflags the arguments of the program, flag files expanded. -h is --help, --help=all is
// --helpfull and --help=GROUP is --helpon=GROUP. Throws InputError for a bad flag. The message has
// the sentence of `unknown`, or the described flag with the most similar name.
void ParseCommandLine(std::vector<std::string> arguments, const std::vector<FlagHelp>& flags,
                      const UnknownFlag& unknown);

// What is asked for instead of a run: help, the version, or the words that complete a command line
// (--help=words: see CompletionWords()); an empty text if nothing is. `flags` are those of the
// selected mode, `all` those of all modes. Throws InputError that lists the groups if help on
// another one is asked for.
std::string AskedFor(const std::string& program, const std::string& summary,
                     const std::vector<FlagHelp>& flags, const std::vector<FlagHelp>& all);

}  // namespace surfit::tools
