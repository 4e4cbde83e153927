#pragma once

#include <string>

namespace surfit {

bool IsPng(const std::string& bytes);

// Throws InputError naming `path` unless the file's chunks are complete up to IEND and their
// checksums right (PNG specification, 5.3), so that no decoder gets to guess.
void RequireWholePng(const std::string& bytes, const std::string& path);

}  // namespace surfit
