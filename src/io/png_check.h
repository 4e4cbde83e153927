#pragma once

#include <string>

#include "io/image_size.h"

namespace surfit {

bool IsPng(const std::string& bytes);

// Throws InputError naming `path` unless the file's chunks are complete up to IEND and their
// checksums right (PNG specification, 5.3), so that no decoder gets to guess.
void RequireWholePng(const std::string& bytes, const std::string& path);

// The size that the header of such a file claims. Throws InputError naming `path` if it has none,
// or an absurd one.
ImageSize PngSize(const std::string& bytes, const std::string& path);

}  // namespace surfit
