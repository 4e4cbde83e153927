#pragma once

#include <string>

#include "io/image_size.h"
#include "surfit/core/image.h"

namespace surfit {

bool IsJpeg(const std::string& bytes);

// The size that the header claims. Throws InputError naming `path` if it has none, or an absurd
// one.
ImageSize JpegSize(const std::string& bytes, const std::string& path);

// Throws InputError naming `path` unless the picture is whole: decoders make up what is missing of
// a truncated or damaged one and only warn, and here a warning is an error.
Image<Rgb8> DecodeJpeg(const std::string& bytes, const std::string& path);

// quality from 1 to 100; colour is kept at full resolution.
std::string EncodeJpeg(const Image<Rgb8>& image, int quality);

}  // namespace surfit
