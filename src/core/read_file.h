#pragma once

#include <cstddef>
#include <limits>
#include <string>

namespace surfit {

inline constexpr std::size_t kAnySize = std::numeric_limits<std::size_t>::max() - 1;

// All bytes of a regular file. Throws InputError naming the file if it cannot be read, has more
// than `most` bytes, or is something else, which might never end or hold the program up for good: a
// device, a pipe.
std::string ReadFile(const std::string& path, std::size_t most = kAnySize);

// The same for what a user has named, who may name a pipe or a device: of these a gigabyte at most.
std::string ReadFileOrPipe(const std::string& path);

// The text of a file of JSON: 256 megabytes at most, and at most 100 brackets in each other, as
// many as can safely be read and written by recursion.
std::string ReadJsonText(const std::string& path);

}  // namespace surfit
