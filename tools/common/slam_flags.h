#pragma once

#include <map>
#include <string>

#include "surfit/slam/slam.h"

namespace surfit::tools {

// The flags of preprocessing and registration, shared by all programs that register frames.
PreprocessOptions PreprocessOptionsFromFlags();
IcpOptions IcpOptionsFromFlags();

// All flags of our own programs with their present values.
std::map<std::string, std::string> RecordedFlags();

}  // namespace surfit::tools
