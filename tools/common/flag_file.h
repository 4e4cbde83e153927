#pragma once

#include <string>
#include <vector>

namespace surfit::tools {

// The arguments with each --flagfile=F (or --flagfile F) replaced by the lines of F, one flag a
// line, without empty lines and # comments. gflags' own reader passes over flags that it does not
// know; as arguments they are refused, wherever they stand. Throws InputError naming a file that
// cannot be read, or that names another one.
std::vector<std::string> ExpandFlagFiles(const std::vector<std::string>& arguments);

}  // namespace surfit::tools
