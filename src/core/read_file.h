#pragma once

#include <string>

namespace surfit {

// All bytes of a file, or of a pipe. Throws InputError naming the file if it cannot be read.
std::string ReadFile(const std::string& path);

}  // namespace surfit
