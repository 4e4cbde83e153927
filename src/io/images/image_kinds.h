#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/images/image_files.h"
#include "surfit/core/error.h"

namespace surfit {

// Decoders of the image formats, called by image_files.h. `bytes` must have the right format and
// pass SizeInHeader(). All functions throw InputError with `path`.
RawDepth DecodeDepthPng(const std::string& bytes, const std::string& path);
Image<std::uint8_t> DecodeConfidencePng(const std::string& bytes, const std::string& path);
Image<Rgb8> DecodeColorPng(const std::string& bytes, const std::string& path);
RawDepth DecodeDepthTiff(const std::string& bytes, const std::string& path);
Image<std::uint8_t> DecodeConfidenceTiff(const std::string& bytes, const std::string& path);
Image<Rgb8> DecodeColorTiff(const std::string& bytes, const std::string& path);
RawDepth DecodeDepthPnm(const std::string& bytes, const std::string& path);
Image<std::uint8_t> DecodeConfidencePnm(const std::string& bytes, const std::string& path);
Image<Rgb8> DecodeColorPnm(const std::string& bytes, const std::string& path);

// Chunk of a PNG file: four-letter type and data, as views of the file's bytes.
struct PngChunk {
  std::string_view type, data;
};

// Returns the chunks of a PNG file up to IEND. Throws InputError with `path` if a chunk is
// truncated or has a wrong checksum (PNG specification, 5.3). The views are valid as long as `png`,
// which must begin with the PNG signature.
std::vector<PngChunk> PngChunks(const std::string& png, const std::string& path);

// Fast decoders of PNG files without interlacing: 16-bit grey or 8-bit RGB. `png`: result of
// PngChunks() for a file that passes SizeInHeader(). Return std::nullopt for other files and for
// damaged data, which libpng then decodes or rejects.
std::optional<Image<std::uint16_t>> ReadPlainCounts(const std::vector<PngChunk>& png);
std::optional<Image<Rgb8>> ReadPlainColor(const std::vector<PngChunk>& png);

// Array of NumPy (.npy) with one number per pixel: 16-bit unsigned counts, 32-bit or 64-bit floats
// (converted to 32 bits).
RawDepth DecodeDepthNpy(const std::string& bytes, const std::string& path);
// OpenEXR image of one part in scan lines, see exr_images.cc.
RawDepth DecodeDepthExr(const std::string& bytes, const std::string& path);

bool IsNpy(const std::string& bytes);
bool IsExr(const std::string& bytes);
// Image size from the header of a .npy file: the shape (height, width) or (height, width, 1).
ImageSize NpySize(const std::string& bytes, const std::string& path);
// Image size from the data window of an OpenEXR file.
ImageSize ExrSize(const std::string& bytes, const std::string& path);

bool IsTiff(const std::string& bytes);
bool IsPnm(const std::string& bytes);

// Image size from the header of a PGM or PPM file.
ImageSize PnmSize(const std::string& bytes, const std::string& path);

// Errors, which the caller throws. `bits`: per channel.
InputError NotADepthImage(int channels, int bits, const std::string& path);
InputError NotAConfidenceImage(int channels, int bits, const std::string& path);
InputError DamagedImage(const std::string& path);

}  // namespace surfit
