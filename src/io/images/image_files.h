#pragma once

#include <cstdint>
#include <string>

#include "surfit/core/image.h"
#include "surfit/frame/rectify_frame.h"

namespace surfit {

// Width and height in px.
struct ImageSize {
  int width = 0;
  int height = 0;

  std::size_t pixels() const { return static_cast<std::size_t>(width) * height; }
  friend bool operator==(ImageSize a, ImageSize b) {
    return a.width == b.width && a.height == b.height;
  }
  friend bool operator!=(ImageSize a, ImageSize b) { return !(a == b); }
};

// Throws InputError with `path` if width or height is below 1 or above 16384. Prevents huge
// allocations for damaged headers.
void RequireValidSize(ImageSize size, const std::string& path);

// Readers of image files: PNG, JPEG, TIFF, PGM and PPM of up to 1 GiB; depth also as OpenEXR and as
// an array of NumPy. All functions throw InputError with the path if the file is missing,
// truncated, visibly damaged or of another format.

// One channel of 16-bit raw counts, or of floats in metres. JPEG is refused. Missing depth is kept
// as stored.
RawDepth ReadDepthImage(const std::string& path);
RawDepth DecodeDepthImage(const std::string& bytes, const std::string& path);

// Image of one channel of 8 bits: values as stored. JPEG is refused, because compression changes
// the values.
Image<std::uint8_t> ReadConfidenceImage(const std::string& path);
Image<std::uint8_t> DecodeConfidenceImage(const std::string& bytes, const std::string& path);

// 8-bit RGB. Grey images get three equal channels. Orientation tags are ignored, because the
// intrinsics refer to the stored pixels.
Image<Rgb8> ReadColorImage(const std::string& path);
Image<Rgb8> DecodeColorImage(const std::string& bytes, const std::string& path);

// Tests the first bytes only, as IsPng().
bool IsJpeg(const std::string& bytes);

// Image size from the header, without decoding. Throws InputError with `path` for an unknown
// format, an invalid size, or more pixels than the file size permits.
ImageSize SizeInHeader(const std::string& bytes, const std::string& path);

// SizeInHeader() of a JPEG file that may be truncated after its header.
ImageSize JpegSize(const std::string& bytes, const std::string& path);

// Throws InputError with `path` if the image is truncated or damaged, or if its colours are CMYK.
// Up to 64 stray bytes after the last pixel are ignored.
Image<Rgb8> DecodeJpeg(const std::string& bytes, const std::string& path);

// `quality`: 1 to 100. Chroma is not subsampled. Throws InputError if encoding fails, including out
// of memory.
std::string EncodeJpeg(const Image<Rgb8>& image, int quality);

// Fast compression: files are about one third larger than with default settings. Throw as
// EncodeJpeg(), also for an empty image.
std::string EncodePng(const Image<Rgb8>& image);
std::string EncodePng(const Image<std::uint16_t>& image);
std::string EncodePng(const Image<std::uint8_t>& image);

bool IsPng(const std::string& bytes);

// SizeInHeader() of a PNG file that may be truncated after its header.
ImageSize PngSize(const std::string& bytes, const std::string& path);

}  // namespace surfit
