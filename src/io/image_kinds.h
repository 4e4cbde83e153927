#pragma once

#include <string>

#include "io/image_files.h"
#include "surfit/core/error.h"

namespace surfit {

// The decoders of each kind of image file, called by what stands in image_files.h. Their bytes are
// a file of that kind whose header claims a size that they can hold (ClaimedSize). All throw
// InputError naming `path`.
RawDepth DecodeDepthPng(const std::string& bytes, const std::string& path);
Image<Rgb8> DecodeColorPng(const std::string& bytes, const std::string& path);
RawDepth DecodeDepthTiff(const std::string& bytes, const std::string& path);
Image<Rgb8> DecodeColorTiff(const std::string& bytes, const std::string& path);
RawDepth DecodeDepthPnm(const std::string& bytes, const std::string& path);
Image<Rgb8> DecodeColorPnm(const std::string& bytes, const std::string& path);

bool IsTiff(const std::string& bytes);
bool IsPnm(const std::string& bytes);  // PGM and PPM

// The size that a PGM or PPM claims.
ImageSize PnmSize(const std::string& bytes, const std::string& path);

InputError NotADepthImage(int channels, int bits, const std::string& path);
InputError DamagedImage(const std::string& path);

}  // namespace surfit
