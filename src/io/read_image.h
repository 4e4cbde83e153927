#pragma once

#include <string>

#include "surfit/core/image.h"
#include "surfit/frame/prepare_frame.h"

namespace surfit {

// Image files of any kind that OpenCV reads. All throw InputError naming the file if it is
// missing, truncated, damaged (as far as its kind can tell) or of another kind.

// 16-bit counts or 32-bit float metres of one channel.
RawDepth ReadDepthImage(const std::string& path);
RawDepth DecodeDepthImage(const std::string& bytes, const std::string& path);

// 8-bit colour; grey is spread over the channels. The file's pixels as they are: an orientation
// tag is ignored, for the camera's geometry belongs to the pixels.
Image<Rgb8> ReadColorImage(const std::string& path);
Image<Rgb8> DecodeColorImage(const std::string& bytes, const std::string& path);

}  // namespace surfit
