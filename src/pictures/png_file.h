#pragma once

#include <string>

#include "surfit/core/image.h"

namespace surfit {

// Throws InputError naming the path where the file cannot be written.
void WritePng(const Image<Rgb8>& image, const std::string& path);

}  // namespace surfit
