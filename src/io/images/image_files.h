#pragma once

#include <cstdint>
#include <string>

#include "surfit/core/image.h"
#include "surfit/frame/prepare_frame.h"

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

// Throws InputError naming `path` if either is below 1 or above 16384, so that a damaged header
// cannot ask for all memory.
void RequireUsualSize(ImageSize size, const std::string& path);

// Image files: PNG, JPEG, TIFF, PGM or PPM, of a gigabyte at most. All throw InputError naming the
// file if it is missing, truncated, damaged (as far as its kind can tell) or of another kind.

// 16-bit counts or 32-bit float metres of one channel.
RawDepth ReadDepthImage(const std::string& path);
RawDepth DecodeDepthImage(const std::string& bytes, const std::string& path);

// 8-bit colour; grey is spread over the channels. The file's pixels as they are: an orientation
// tag is ignored, for the camera's geometry belongs to the pixels.
Image<Rgb8> ReadColorImage(const std::string& path);
Image<Rgb8> DecodeColorImage(const std::string& bytes, const std::string& path);

bool IsJpeg(const std::string& bytes);

// The size that the header of an image of any of these kinds claims. Throws InputError naming
// `path` if it is none of them, or claims an absurd size or more pixels than so few bytes can hold.
ImageSize ClaimedSize(const std::string& bytes, const std::string& path);

// The same of a JPEG, however many bytes of it there are.
ImageSize JpegSize(const std::string& bytes, const std::string& path);

// Throws InputError naming `path` unless the picture is whole: decoders make up what is missing of
// a truncated or damaged one and only warn, and here a warning is an error.
Image<Rgb8> DecodeJpeg(const std::string& bytes, const std::string& path);

// quality from 1 to 100; colour is kept at full resolution. Throws InputError, as where memory is
// missing.
std::string EncodeJpeg(const Image<Rgb8>& image, int quality);

// Quick to write, a third larger than need be. Throw InputError as EncodeJpeg does.
std::string EncodePng(const Image<Rgb8>& image);
std::string EncodePng(const Image<std::uint16_t>& image);

bool IsPng(const std::string& bytes);

// The size that the header of such a file claims, however many bytes of it there are. Throws
// InputError naming `path` if it has none, or an absurd one.
ImageSize PngSize(const std::string& bytes, const std::string& path);

}  // namespace surfit
