#pragma once

#include <string>

#include "io/bags/messages.h"
#include "surfit/core/image.h"
#include "surfit/frame/prepare_frame.h"

namespace surfit {

// What a message of an image holds.
enum class ImageKind { kDepth, kColor, kGrey, kUnreadable };

// Of images that are 16-bit grey, only the topic's name tells whether they are depth.
ImageKind KindOf(const ImageMessage& message, const std::string& topic);

// Depth: 16UC1 or mono16 (counts), 32FC1 (metres), PNG of 16 bits, or the PNG of
// compressed_depth_image_transport. Throws InputError naming `name` if it is none of these, or
// damaged.
RawDepth DepthOf(const ImageMessage& message, const std::string& name);

// Colour: rgb8, bgr8, rgba8, bgra8, 8UC3 and 8UC4 (blue first, as OpenCV has them), mono8, 8UC1, or
// a compressed image in any format of DecodeColorImage(). Throws likewise.
Image<Rgb8> ColorOf(const ImageMessage& message, const std::string& name);

}  // namespace surfit
