#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/flags.h"

namespace surfit::tools {

// Replaces each --flagfile=F (or --flagfile F) by the lines of F, one flag per line, without empty
// lines and # comments. Unknown flags in these files are rejected, in contrast to the flag files of
// gflags. Throws InputError with the name of a file that cannot be read, has 1 MiB or more, or
// includes another flag file.
std::vector<std::string> ExpandFlagFiles(const std::vector<std::string>& arguments);

// The arguments with the present names of renamed flags. Logs a warning per renamed flag.
std::vector<std::string> WithPresentNames(std::vector<std::string> arguments);

// Explains why a program does not have a flag. Returns an empty text for unknown flags.
using UnknownFlag = std::function<std::string(const std::string& flag)>;

// Parses the arguments with gflags. Call order: ExpandFlagFiles(), WithPresentNames(), construction
// of Flags, ParseCommandLine(), RequestedText(). -h is --help, --help=all is --helpfull and
// --help=GROUP is --helpon=GROUP. --serve is --serve=0. Throws InputError for an invalid flag and
// for an argument that is not a flag. For an unknown flag, the message contains the sentence of
// `unknown`, or else the most similar flag, if any.
void ParseCommandLine(std::vector<std::string> arguments, const std::vector<FlagHelp>& flags,
                      const UnknownFlag& unknown);

// Returns the text of --help, --version or --help=words (CompletionWords()); empty if a run is
// requested. `flags` are the flags of the selected mode, `all` those of Modes::Described(). Throws
// InputError with a list of the groups for help on an unknown group.
std::string RequestedText(const std::string& program, const std::string& summary,
                          const std::vector<FlagHelp>& flags, const std::vector<FlagHelp>& all);

}  // namespace surfit::tools
