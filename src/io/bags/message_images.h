#pragma once

#include <string>

#include "io/bags/messages.h"
#include "surfit/core/image.h"
#include "surfit/frame/rectify_frame.h"

namespace surfit {

// Use of an image. kUnreadable: unknown encoding.
enum class ImageKind { kDepth, kColor, kGrey, kUnreadable };

// Kind of an image by its encoding, for compressed images by format and first bytes. Single-channel
// 8-bit images are kGrey. mono16 is depth if the topic name contains "depth" in any case, otherwise
// unreadable. Compressed PNG and JPEG images without a hint in the format are kColor.
ImageKind KindOf(const ImageMessage& message, const std::string& topic);

// Decodes a depth image: 16UC1 or mono16 (counts) and 32FC1 (metres) in either byte order, a
// compressed image in a format of DecodeDepthImage(), or the PNG of
// compressed_depth_image_transport. Throws InputError with `name` for other encodings and damaged
// images. The last format with 32FC1 stores inverse depth, which is converted to m (0: missing).
// Other missing depth is kept as stored.
RawDepth DepthOf(const ImageMessage& message, const std::string& name);

// Decodes a colour image: rgb8, bgr8, rgba8, bgra8, 8UC3 and 8UC4 (BGR order as in OpenCV), mono8,
// 8UC1, or a compressed image in a format of DecodeColorImage(). Throws InputError with `name` for
// other encodings and damaged images. Grey images get three equal channels.
Image<Rgb8> ColorOf(const ImageMessage& message, const std::string& name);

}  // namespace surfit
