#pragma once

#include <cstdint>
#include <string>

#include "io/image_size.h"
#include "surfit/core/image.h"

namespace surfit {

// The images within .klg and .sens files. All throw InputError naming `name` unless the bytes hold
// an image of that size; it is compared with what they can hold before memory is taken for it.

// 16-bit little endian counts, row by row.
Image<std::uint16_t> CopyDepth(const std::string& bytes, ImageSize size, const std::string& name);
// The same compressed by zlib.
Image<std::uint16_t> InflateDepth(const std::string& bytes, ImageSize size,
                                  const std::string& name);

// Red, green, blue, row by row.
Image<Rgb8> CopyColor(const std::string& bytes, ImageSize size, const std::string& name);
// JPEG or PNG.
Image<Rgb8> DecodeColor(const std::string& bytes, ImageSize size, const std::string& name);

}  // namespace surfit
