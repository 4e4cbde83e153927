#pragma once

#include <string>

namespace surfit::tools {

// Sentence that names the replacement of a removed flag. Empty for other flags.
std::string Replacement(const std::string& program, const std::string& flag);

}  // namespace surfit::tools
