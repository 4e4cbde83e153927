#pragma once

#include <string>

#include "surfit/core/image.h"

namespace surfit {

bool IsJpeg(const std::string& bytes);

// Throws InputError naming `path` unless the picture is whole: decoders make up what is missing of
// a truncated or damaged one and only warn, and here a warning is an error.
Image<Rgb8> DecodeJpeg(const std::string& bytes, const std::string& path);

}  // namespace surfit
