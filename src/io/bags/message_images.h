#pragma once

#include <string>

#include "io/bags/messages.h"
#include "surfit/core/image.h"
#include "surfit/frame/rectify_frame.h"

namespace surfit {

enum class ImageKind { kDepth, kColor, kGrey, kUnreadable };

// Kind of an image by its encoding. mono16 is depth if the topic name contains "depth".
ImageKind KindOf(const ImageMessage& message, const std::string& topic);

// Decodes a depth image: 16UC1 or mono16 (counts), 32FC1 (metres), a 16-bit PNG, or the PNG of
// compressed_depth_image_transport. Throws InputError with `name` for other encodings and damaged
// images.
RawDepth DepthOf(const ImageMessage& message, const std::string& name);

// Decodes a colour image: rgb8, bgr8, rgba8, bgra8, 8UC3 and 8UC4 (BGR order as in OpenCV), mono8,
// 8UC1, or a compressed image in a format of DecodeColorImage(). Throws InputError with `name` for
// other encodings and damaged images.
Image<Rgb8> ColorOf(const ImageMessage& message, const std::string& name);

}  // namespace surfit
